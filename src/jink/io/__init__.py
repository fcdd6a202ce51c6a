"""Files and frames of reference: what comes in, how it is cleaned and placed, and what goes out."""
