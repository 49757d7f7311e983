"""One module per command, each with a click command named `command`; `slider_drilling.cli` lists them."""
