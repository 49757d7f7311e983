"""What a fit is worth: likelihood, predictive score, comparison, adequacy, flexible rivals."""
