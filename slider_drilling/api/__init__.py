"""The functions that `import slider_drilling as sd` offers; the command line uses the same."""
