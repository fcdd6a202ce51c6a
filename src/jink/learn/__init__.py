"""How parameters are found: fuzzy rules by evolution, correctors and noise networks by gradients."""
