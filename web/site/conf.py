"""Configuration of Sphinx for the site of the pages that `gather.py` has laid out; run by `cargo xtask site`."""

from __future__ import annotations

from html import escape
from importlib.metadata import version as installed
from pathlib import Path
from typing import TYPE_CHECKING, Any

from docutils import nodes
from sphinx.addnodes import pending_xref

if TYPE_CHECKING:
    from docutils.nodes import document
    from sphinx.application import Sphinx

SHORTEST, LONGEST = 40, 160
"""Characters of the description of a page."""

project = "Pneumatic servo cylinder"
project_copyright = "the Pneumatic servo cylinder developers, MIT or Apache-2.0"
version = release = installed("pneumatic-servo")
language = "en"

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
exclude_patterns = ["extra", "templates", "repository.txt"]

# Anchors as a forge makes them, down to the headings that pages link to.
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]

# The tutorial runs while the site is made; a cell that fails ends the build.
nb_execution_mode = "force"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True

# Docstrings are those that `help` shows: NumPy's sections, and names between single backticks.
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
ALIASES = ["ArrayLike", "Input", "Inputs", "Parameters", "Progress", "Value", "Values"]
autodoc_type_aliases = {name: name for name in ALIASES}
autodoc_default_options = {"members": True, "show-inheritance": True}
napoleon_google_docstring = False

html_theme = "furo"
html_title = f"Pneumatic servo cylinder {release}"
html_static_path = ["static"]
html_favicon = "static/favicon.svg"
templates_path = ["templates"]
# The parts of the theme's side bar, with two links before the pages.
SIDE_BAR = ["brand", "search", "scroll-start", "first", "navigation", "scroll-end"]
html_sidebars = {"**": [f"sidebar/{part}.html" for part in SIDE_BAR]}
html_css_files = ["site.css"]
html_js_files = ["scroll.js"]
html_extra_path = ["extra"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {
    "navigation_with_keys": True,
    "light_css_variables": {"color-brand-primary": "#0b5c98", "color-brand-content": "#0b5c98"},
    "dark_css_variables": {"color-brand-primary": "#7fc1f5", "color-brand-content": "#7fc1f5"},
}
# The manifest of the workspace names the repository, once it has an address.
if repository := (Path(__file__).parent / "repository.txt").read_text(encoding="utf-8"):
    icon = {"name": "Repository", "url": repository, "html": "<span>Repository</span>", "class": ""}
    html_theme_options["footer_icons"] = [icon]
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "a11y-high-contrast-dark"
copybutton_exclude = ".linenos, .gp, .go"


def setup(app: Sphinx) -> None:
    """Add what the pages need beyond the settings."""
    app.connect("html-page-context", _level, priority=900)
    app.connect("html-page-context", _description)
    app.connect("doctree-read", _words_of_types)


def _description(_app: Sphinx, _page: str, _template: str, context: dict[str, Any], doctree: document | None) -> None:
    """Describe a page by its first paragraph, for other searches, unless it describes itself."""
    if 'name="description"' in context.get("metatags", ""):
        return
    found = doctree.findall(nodes.paragraph) if doctree is not None else ()
    paragraphs = (" ".join(paragraph.astext().split()) for paragraph in found)
    first = next((text for text in paragraphs if len(text) >= SHORTEST), "")
    text = first or f"{context.get('title', '')}: {project}"
    if len(text) > LONGEST:
        text = text[:LONGEST].rpartition(" ")[0].rstrip(",;:") + " …"
    context["metatags"] = f'{context.get("metatags", "")}\n<meta name="description" content="{escape(text)}">'


def _level(_app: Sphinx, _page: str, _template: str, context: dict[str, Any], _doctree: object) -> None:
    """Give the headings of the side bar a level, which a screen reader asks for."""
    tree = context.get("furo_navigation_tree", "")
    context["furo_navigation_tree"] = tree.replace('role="heading"', 'role="heading" aria-level="2"')


def _words_of_types(_app: Sphinx, doctree: document) -> None:
    """Leave the words of a type such as `ndarray of shape (runs,)` as text: Sphinx takes each for a name to link."""
    for reference in list(doctree.findall(pending_xref)):
        word = reference["reftarget"]
        if reference.get("refdomain") == "py" and "refspecific" in reference and word.islower() and "." not in word:
            reference.replace_self(reference.children)
