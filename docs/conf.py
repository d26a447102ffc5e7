"""Configuration of the documentation site: `sphinx-build -W docs site` builds it (docs/contributing.md)."""

import re
import sys
from pathlib import Path

from docutils import nodes

import attitude
from attitude.plot.style import SETTINGS

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS))
from generated_pages import http_page, scene_page  # noqa: E402

GENERATED = DOCS / "reference" / "generated"

project = "attitude"
author = copyright = "the attitude developers"
version = release = attitude.__version__

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.intersphinx",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx-mathjax-offline",
    "sphinx_gallery.gen_gallery",
    "sphinxarg.ext",
]
exclude_patterns = ["gallery", "_templates"]
templates_path = ["_templates"]
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_title = f"attitude {version}"
html_show_sourcelink = False
suppress_warnings = ["config.cache", "myst.domains"]  # of other packages' configuration and domains
myst_enable_extensions = ["amsmath", "colon_fence", "dollarmath"]
myst_heading_anchors = 3
autosummary_generate = True
numpydoc_show_class_members = False
autodoc_typehints = "none"
mathjax3_config = {"chtml": {"scale": 0.92}}  # as large as the text, by its capitals
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True


def in_our_style(gallery, name):
    """Pictures of the gallery look like those that the library draws."""
    import matplotlib as mpl

    mpl.rcParams.update(SETTINGS)


sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "auto_gallery",
    "within_subsection_order": "ExampleTitleSortKey",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "min_reported_time": 5,
    "remove_config_comments": True,
    "reset_modules": ("matplotlib", in_our_style),
    "show_memory": False,
    "write_computation_times": False,  # its table asks other hosts for scripts
}

# Only where the build may ask the network: `-t offline` leaves the links to other projects out.
intersphinx_mapping = {
    "python": ("https://docs.python.org/3", None),
    "numpy": ("https://numpy.org/doc/stable/", None),
    "scipy": ("https://docs.scipy.org/doc/scipy/", None),
    "astropy": ("https://docs.astropy.org/en/stable/", None),
}
if tags.has("offline"):  # noqa: F821 (a name that Sphinx provides)
    intersphinx_mapping = {}

html_theme = "pydata_sphinx_theme"
html_theme_options = {
    "header_links_before_dropdown": 7,
    "navbar_end": ["search-button", "theme-switcher"],
    "navbar_persistent": [],
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "show_toc_level": 2,
}

# Pages of the repository that stand beside docs/, and where the site has them.
BESIDE = {
    "README.md": "/readme.md",
    "CONTRIBUTING.md": "/contributing.md",
    "CHANGELOG.md": "/changelog.md",
    "CITATION.cff": "/../CITATION.cff",
    "SECURITY.md": "/security.md",
    "service/viewer/README.md": "/viewer.md",
}


def write_descriptions(app):
    """Reference pages of the routes and of scenes, from what the program itself says of them."""
    from service.app import app as service

    GENERATED.mkdir(exist_ok=True)
    scene = attitude.Scene.model_json_schema()
    (GENERATED / "scene.md").write_text(scene_page(scene))
    (GENERATED / "http.md").write_text(http_page(service.openapi(), scene))


def lead_into_the_site(text):
    """Links to pages that stand beside docs/, and to scripts of the gallery, lead to the site's own pages."""
    for beside, page in BESIDE.items():
        text = re.sub(rf"\]\((?:\.\./)*{re.escape(beside)}", f"]({page}", text)
    return re.sub(r"\]\((?:\.\./)*gallery/(plot_\w+)\.py\)", r"](/auto_gallery/\1.rst)", text)


def on_page(app, name, content):
    content[0] = lead_into_the_site(content[0])


def on_include(app, path, name, content):
    content[0] = lead_into_the_site(content[0])


def number_long_formulas(app, doctree):
    """Formulas of several lines are given to MathJax as they are: Sphinx would set them in `split`, where
    a formula has no number."""
    for formula in doctree.findall(nodes.math_block):
        if r"\\" in formula.astext():
            formula["no-wrap"] = True
            formula[:] = [nodes.Text(rf"\[{formula.astext()}\]")]


def setup(app):
    app.connect("doctree-read", number_long_formulas)
    app.connect("builder-inited", write_descriptions)
    app.connect("source-read", on_page)
    app.connect("include-read", on_include)
