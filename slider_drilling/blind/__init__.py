"""The diagnosis on trial: logs whose effect is sealed, and how often it was found."""
