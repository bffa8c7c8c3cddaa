"""How Sphinx makes the site. `cargo xtask site` runs it, and takes every warning for an error."""

import json
import re
from os.path import normpath
from pathlib import Path

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.addnodes import pending_xref
from sphinx.util import logging
from sphinx.util.osutil import relative_uri
from sphinx_inline_tabs._impl import TabContainer

project = html_title = "vibroimpact"
extensions = ["myst_parser", "sphinx_copybutton", "sphinx_inline_tabs"]
# The pages lie where a repository's reader finds them; contents.md is their order.
root_doc = "README"
include_patterns = ["*.md", "docs/**.md", "tests/fuzz/README.md"]
exclude_patterns = [".git", "out", "target"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 6
# A page reads here as it does in the repository.
myst_disable_syntax = ["myst_line_comment", "myst_block_break", "myst_target", "myst_role"]
myst_dmath_allow_space = myst_dmath_allow_digits = smartquotes = False
highlight_language = "none"
nitpicky = True

html_theme = "furo"
html_static_path = ["style.css", "search.js", "pictures.js"]
html_js_files = [("pictures.js", {"defer": "defer"})]
html_css_files = ["style.css"]
templates_path = ["."]
bars = ["brand", "search", "scroll-start", "navigation"]
html_sidebars = {"**": [f"sidebar/{bar}.html" for bar in bars] + ["elsewhere.html", "sidebar/scroll-end.html"]}
html_math_renderer = "mathml"
html_copy_source = html_use_index = html_show_copyright = html_show_search_summary = False

# What may stand in the site before Sphinx writes its pages.
ELSEWHERE = {
    "figures/index.html": "The chapter's figures",
    "explore.html": "The page",
    "rust/numerics/index.html": "Rust crates",
    "python-api/vibroimpact.html": "Python package",
}
# Which of these stands in a page that tells of it.
WITHIN = {"docs/figures": "figures/index.html", "docs/tutorial-explore": "explore.html"}
# What a browser without a font for mathematics draws badly of docutils' MathML, and what it draws well.
DRAWN = [
    (r"\n\s*", ""),
    ("<mi>([α-ω∂])<", r'<mi class="slanted" mathvariant="normal">\1<'),
    ("<mi[^>]*>([Α-Ω∇])<", r'<mi mathvariant="normal">\1<'),
    (r"<mi>(\w+)</mi><mo>&ApplyFunction;", r'<mo form="infix" lspace="0.17em" rspace="0.17em">\1'),
    ("(?<!<mrow>)<mo>([{}])</mo>(?!</mrow>)", r'<mo stretchy="false">\1</mo>'),
    (r'<mo stretchy="false">\|', '<mo stretchy="false" lspace="0" rspace="0">|'),
]
# Words that say nothing, and turns that a stranger must read twice.
AVOIDED = re.compile(
    r"\b(which of the two|let be|to be had|the worse for|not measured again|before the last|all the same|simply|easily"
    r"|obviously|of course|very|in order to)\b",
    re.IGNORECASE,
)
log = logging.getLogger(__name__)


def with_contents(app, page, source):
    if page == root_doc:
        source[0] += "\n" + Path(app.confdir, "contents.md").read_text("utf-8")


def link_to_folder(app, page, link):
    """A folder of the project is no page: it leads to its crate's documentation, or only its words stay."""
    name = normpath(Path(page).parent / link["reftarget"])
    if Path(app.srcdir, name).is_dir():
        to = f"rust/{name.replace('-', '_')}/index.html"
        uri = relative_uri(app.builder.get_target_uri(page), to)
        made = Path(app.outdir, to).exists()
        link.replace_self(nodes.reference("", "", *link.children, internal=True, refuri=uri) if made else link.children)


def formula(writer, node):
    latex = node.astext()
    try:
        text = tex2mathml(latex, as_block=isinstance(node, nodes.math_block))
        # docutils closes by itself what is left open.
        bare = re.sub(r"\\[{}]", "", latex)
        for start, end in [("{", "}"), (r"\\left\b", r"\\right\b"), (r"\\begin\b", r"\\end\b")]:
            if len(re.findall(start, bare)) != len(re.findall(end, bare)):
                raise MathError(f"not as many {start} as {end}")
    except MathError as error:
        log.warning("the formula %s: %s", latex, error, location=node)
        raise nodes.SkipNode
    for pattern, drawn in DRAWN:
        text = re.sub(pattern, drawn, text)
    writer.body.append(text)
    raise nodes.SkipNode


def draw_tabs(doctree):
    """A list whose entries begin with a line in bold becomes tabs."""
    for entries in list(doctree.findall(nodes.bullet_list)):
        heads = [entry[0] for entry in entries]
        if all(head.astext() == "".join(part.astext() for part in head.findall(nodes.strong)) for head in heads):
            label = [nodes.label("", head.astext()) for head in heads]
            shown = [nodes.container("", *entry[1:], is_div=True, classes=["tab-content"]) for entry in entries]
            entries.replace_self([TabContainer("", *tab, type="tab", new_set=False) for tab in zip(label, shown)])


def read(app, doctree):
    page = app.env.docname
    draw_tabs(doctree)
    if Path(app.outdir, shown := WITHIN.get(page, "-")).exists():
        frame = nodes.raw("", f'<iframe src="../{shown}" title="{ELSEWHERE[shown]}" loading="lazy"></iframe>', format="html")
        doctree[0].insert(doctree[0].first_child_matching_class(nodes.section), frame)
    for link in list(doctree.findall(pending_xref)):
        if link["reftype"] == "myst" and link["refdomain"] is None:
            link_to_folder(app, page, link)
        # A page's or a section's title says more than the name of its file.
        elif re.fullmatch(r"[\w-]+\.md", link.astext()):
            link["refexplicit"] = False
    for picture in doctree.findall(nodes.image):
        if not picture.get("alt"):
            log.warning("a picture without words", location=picture)
    for paragraph in doctree.findall(nodes.paragraph):
        for turn in AVOIDED.findall(paragraph.astext()):
            log.warning("say it without “%s”", turn, location=paragraph)
    for section in doctree.findall(nodes.section):
        words = [part.astext() for part in section.children[1:] if not isinstance(part, nodes.section)]
        app.sections.append([page, section["ids"][0], section[0].astext(), " ".join(" ".join(words).split())])


def frame(app, page, template, context, doctree):
    context["elsewhere"] = [entry for entry in ELSEWHERE.items() if Path(app.outdir, entry[0]).exists()]
    if page == "search":
        for name in ["sections.js", "search.js"]:
            app.add_js_file(name, loading_method="defer")


def finish(app, error):
    if not error:
        text = json.dumps(app.sections, ensure_ascii=False)
        Path(app.outdir, "_static/sections.js").write_text(f"Search.sections = {text};\n", "utf-8")
        start = '<meta http-equiv="refresh" content="0; url=README.html"><a href="README.html">To the first page</a>\n'
        Path(app.outdir, "index.html").write_text(start)


def setup(app):
    app.sections = []
    app.add_html_math_renderer("mathml", (formula, None), (formula, None))
    app.connect("source-read", with_contents)
    app.connect("doctree-read", read)
    app.connect("html-page-context", frame)
    app.connect("build-finished", finish)
