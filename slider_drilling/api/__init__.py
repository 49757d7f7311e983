"""What `import slider_drilling as sd` offers, each behind one function; the command line is built on the same."""
