"""How parameters are found: by gradients through the filter, fuzzy rules by evolution, networks on residuals."""
