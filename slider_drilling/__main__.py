"""`python -m slider_drilling`: the same as the console script."""

from slider_drilling.cli import main

if __name__ == "__main__":
    main()
