"""What `make docs` makes of the code: reference pages and pictures. Nothing of it is in the package."""
