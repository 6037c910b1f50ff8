"""How Sphinx builds these pages: `make docs`."""

from blockstab import __version__

project = "blockstab"
version = release = __version__
extensions = ["myst_parser"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "results", "figures"]
html_theme = "furo"
html_title = f"{project} {version}"
html_copy_source = False
