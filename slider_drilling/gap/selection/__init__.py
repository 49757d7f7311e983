"""From one explanation to the next: the steps of the attribution and what is known after each."""
