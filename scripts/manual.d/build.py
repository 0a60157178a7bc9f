# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the manual with Sphinx, inside yade:  TALIK_MANUAL=folder yade -n -x scripts/manual.d/build.py html [pdf]

The sources of the manual are the pages of the repository as they lie, by links, so that what links one to the other links there too. Added are
the first page, the reference, made from the help texts, and the gallery, made from the examples.
"""

import ast
import os
import shutil
import sys
from pathlib import Path

here = Path(sys.argv[0]).resolve().parent
root = here.parents[1]
sys.path.insert(0, str(here))

import reference  # noqa: E402: the folder beside this script

from sphinx.cmd.build import main as sphinx  # noqa: E402

pagesOfRepository = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "CITATION.cff", ".codemeta.json", "LICENSE", "examples", "pkg")


def gallery():
	"""A page with text and picture of each example."""
	lines = ["# Gallery", "", "Each example is a script like those that a user writes. `scripts/run NAME` runs it. [What they show](examples/README.md).", ""]
	for example in sorted((root / "examples").glob("*.py")):
		text = ast.get_docstring(ast.parse(example.read_text())).split("\n\n")
		lines += [f"## {example.stem}", "", text[0], ""]
		pictures = [example.with_name(example.stem + end) for end in (".png", "_page.png")]
		lines += [f"![{text[0]}](examples/{picture.name})\n" for picture in pictures if picture.exists()][:1]
		script = [f"```{{literalinclude}} examples/{example.name}", ":language: python", "```"]
		lines += ["<details><summary>The script</summary>", "", *script, "", "</details>", ""]
	return "\n".join(lines)


def layOutSources(folder):
	shutil.rmtree(folder, ignore_errors=True)
	(folder / "reference").mkdir(parents=True)
	for name in pagesOfRepository:
		(folder / name).symlink_to(root / name)
	for name in ("index.md", "conf.py", "manual.css"):
		(folder / name).symlink_to(here / name)
	(folder / "gallery.md").write_text(gallery())
	pages = reference.pages()
	for name, text in pages.items():
		(folder / "reference" / f"{name}.rst").write_text(text)
	listed = "\n".join(f"   {name}" for name in pages)
	title = "Reference"
	(folder / "reference" / "index.rst").write_text(f"{title}\n{'=' * len(title)}\n\n.. toctree::\n   :maxdepth: 1\n\n{listed}\n")


def build(output, forms):
	source = output / "source"
	layOutSources(source)
	common = ["-q", "-W", "--keep-going", "-d", str(output / "doctrees")]
	status = sphinx(["-b", "html", *common, str(source), str(output / "html")])
	if not status and "pdf" in forms:
		status = sphinx(["-b", "singlehtml", *common, str(source), str(output / "single")])
		from weasyprint import HTML

		HTML(filename=str(output / "single" / "index.html")).write_pdf(str(output / "manual.pdf"), stylesheets=[str(here / "print.css")])
	return status


sys.stdout.flush()
status = build(Path(os.environ["TALIK_MANUAL"]), sys.argv[1:])
sys.stdout.flush()
os._exit(status)  # yade itself would end with 0
