"""Configuration of the documentation site: `sphinx-build -W docs site` builds it (docs/contributing.md)."""

import json
import re
from pathlib import Path

import attitude
from attitude.plot.style import SETTINGS

DOCS = Path(__file__).parent
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
    "sphinxcontrib.openapi",
    "sphinx-jsonschema",
]
exclude_patterns = ["gallery"]
suppress_warnings = ["config.cache", "myst.domains"]  # of other packages' configuration and domains
myst_enable_extensions = ["amsmath", "colon_fence", "dollarmath"]
myst_heading_anchors = 3
autosummary_generate = True
numpydoc_show_class_members = False
autodoc_typehints = "none"
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True


def in_our_style(gallery, name):
    """Pictures of the gallery look like those that the library draws."""
    import matplotlib as mpl

    mpl.rcParams.update(SETTINGS)


sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "auto_gallery",
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
html_theme_options = {"show_toc_level": 2, "navigation_with_keys": False}

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
    """The HTTP interface and the schema of scenes, as the program itself describes them."""
    from service.app import app as service

    GENERATED.mkdir(exist_ok=True)
    description = service.openapi()
    for methods in description["paths"].values():
        for route in methods.values():
            route["responses"].pop("default", None)  # the renderer knows numbers only
    (GENERATED / "openapi.json").write_text(json.dumps(description))
    (GENERATED / "scene.json").write_text(json.dumps(attitude.Scene.model_json_schema()))


def lead_into_the_site(text):
    """Links to pages that stand beside docs/ lead to the site's own."""
    for beside, page in BESIDE.items():
        text = re.sub(rf"\]\((?:\.\./)*{re.escape(beside)}", f"]({page}", text)
    return text


def on_page(app, name, content):
    content[0] = lead_into_the_site(content[0])


def on_include(app, path, name, content):
    content[0] = lead_into_the_site(content[0])


def setup(app):
    app.connect("builder-inited", write_descriptions)
    app.connect("source-read", on_page)
    app.connect("include-read", on_include)
