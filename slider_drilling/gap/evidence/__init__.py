"""How good a fit is: likelihood, cross-validated score, comparisons, adequacy, and free-form alternatives."""
