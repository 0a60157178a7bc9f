# SPDX-License-Identifier: GPL-2.0-or-later
"""The pages of the repository: what the code cites stands on them, and what they name is there."""

import re
from functools import lru_cache
from pathlib import Path

root = Path(__file__).resolve().parents[2]
pages = sorted([*root.glob("*.md"), *root.glob("examples/*.md"), *root.glob("examples/*/*.md"), *root.glob("pkg/*/*.md")])
roomPages = [page for page in pages if page.parent.parent.name == "pkg" and page.name == "README.md"]

# A number with a point is an equation of the room pages, a whole number one of Yu & Zhao.
citation = re.compile(r"\b[eE]qs?\.? ?((?:\(?\d+(?:\.\d+)?[a-z]?\)?(?:, | and | to |-|–)?)+)")
definition = re.compile(r" {2,}\((\d+\.\d+)\)")


@lru_cache(maxsize=None)
def sources():
	"""Path -> text of every source that this project writes."""
	found = {}
	for folder in ("pkg", "plugin", "scripts", "examples", "tests"):
		for file in sorted((root / folder).rglob("*")):
			if file.suffix in (".hpp", ".cpp", ".inc", ".py", ".sh", ".txt", ".cmake") and file != Path(__file__):
				found[file] = file.read_text()
	return found


def citedNumbers(text):
	for found in citation.finditer(text):
		yield from re.findall(r"\d+(?:\.\d+)?", found.group(1))


def textOf(page):
	return page.read_text()


def withoutCode(text):
	return re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)


def test_every_equation_of_ours_that_code_or_a_page_cites_is_defined_once_on_a_room_page():
	defined = [number for page in roomPages for number in definition.findall(textOf(page))]
	cited = {}
	for file, text in [*sources().items(), *((page, textOf(page)) for page in pages)]:
		for number in citedNumbers(text):
			if "." in number:
				cited.setdefault(number, file.relative_to(root))
	print(f"{len(defined)} equations on {len(roomPages)} pages, {len(cited)} of them cited: {', '.join(sorted(cited))}")
	assert not {number: str(file) for number, file in cited.items() if number not in defined}
	assert sorted(defined) == sorted(set(defined)) and "13.1" in cited


def test_every_equation_of_a_room_page_is_cited_where_code_computes_it():
	cited = {}
	for file, text in sources().items():
		if file.is_relative_to(root / "pkg") or file.is_relative_to(root / "scripts"):
			for number in citedNumbers(text):
				cited.setdefault(number, []).append(file.relative_to(root).name)
	missing = {}
	for page in roomPages:
		numbers = definition.findall(textOf(page))
		missing.update({number: page.parent.name for number in numbers if number not in cited})
		print(f"{page.parent.name}: {', '.join(f'({number}) {cited[number][0]}' for number in numbers if number in cited) or 'none'}")
	assert not missing


def test_every_equation_of_the_paper_that_code_cites_stands_on_a_room_page():
	onPages = set()
	for page in roomPages:
		for found in re.finditer(r"Yu & Zhao, eq\. \((\d+)\)", re.sub(r"\s+", " ", textOf(page))):
			onPages.add(found.group(1))
	cited = {number: str(file.relative_to(root)) for file, text in sources().items() for number in citedNumbers(text) if "." not in number}
	print(f"the code cites equations {', '.join(sorted(cited, key=int))} of the paper, pages explain {', '.join(sorted(onPages, key=int))}")
	assert not {number: file for number, file in cited.items() if number not in onPages} and "8" in cited


def test_every_file_that_a_page_names_exists():
	known = [str(file.relative_to(root)) for file in [*sources(), *pages, Path(__file__).resolve(), *root.glob("scripts/*")]]
	missing, count = [], 0
	for page in pages:
		for name in re.findall(r"`([\w./-]+\.(?:hpp|cpp|inc|py|sh|md))`", textOf(page)):
			if Path(name).name.startswith("Your"):
				continue
			count += 1
			if not any(path == name or path.endswith("/" + name) for path in known):
				missing.append(f"{page.relative_to(root)}: {name}")
	print(f"{count} names of files on {len(pages)} pages")
	assert not missing and count > 50


def test_every_class_and_function_that_a_room_page_names_is_in_the_code():
	words = {word for text in sources().values() for word in re.findall(r"\w+", text)}
	missing, count = [], 0
	for page in [page for page in pages if page.parent.parent.name == "pkg"]:
		for name in re.findall(r"`([A-Za-z_][\w:]*)(?:<\w+>)?(?:\(\))?`", textOf(page)):
			if name.lower().startswith("your"):
				continue
			count += 1
			missing += [f"{page.relative_to(root)}: {name}" for word in name.split("::") if word and word not in words]
	print(f"{count} names of classes, functions and attributes on {len(roomPages)} pages")
	assert not missing and count > 100


def anchors(page):
	"""Of the headings of a page, as GitHub and GitLab form them."""
	headings = re.findall(r"^#+ (.*)$", withoutCode(textOf(page)), re.M)
	return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_every_relative_link_of_every_page_resolves():
	broken, count = [], 0
	for page in pages:
		for target in re.findall(r"\]\(([^)\s]+)\)", withoutCode(textOf(page))):
			if re.match(r"[a-z]+:", target):
				continue
			count += 1
			path, _, anchor = target.partition("#")
			file = (page.parent / path).resolve() if path else page
			if not file.exists() or (anchor and file.suffix == ".md" and anchor not in anchors(file)):
				broken.append(f"{page.relative_to(root)}: {target}")
	print(f"{count} links on {len(pages)} pages")
	assert not broken and count > 20


def test_the_five_steps_on_the_page_are_those_that_the_ground_takes_in_their_order():
	body = re.search(r"void Ground<D>::step\(double dt\)\n\{(.*?)\n\}", (root / "pkg/mpm/Ground.cpp").read_text(), re.S).group(1)
	taken = [call for call in re.findall(r"(\w+)\(", body) if call != "beginStep"]
	section = textOf(root / "pkg/mpm/README.md").split("## The five steps")[1].split("\n## ")[0]
	told = re.findall(r"^\| `(\w+)` \|", section, re.M)
	print(" -> ".join(taken))
	assert told == taken and len(told) == 5


def test_every_room_has_its_theory_and_its_how_to_on_pages_of_their_own_and_the_symbols_of_its_equations():
	rooms = sorted(folder.name for folder in (root / "pkg").iterdir() if folder.is_dir())
	assert rooms == sorted(page.parent.name for page in roomPages)
	for page in roomPages:
		headings = re.findall(r"^## (.*)$", textOf(page), re.M)
		ways = re.findall(r"^## (.*)$", textOf(page.parent / "how-to.md"), re.M)
		assert ways and all(heading.startswith("How to add") for heading in ways), page
		assert not any(heading.startswith("How to add") for heading in headings), page
		assert "Symbols" in headings or not definition.search(textOf(page)), page
		assert not definition.search(textOf(page.parent / "how-to.md")), page
		print(f"{page.parent.name}: {'; '.join(ways)}")


def test_no_line_of_running_text_is_longer_than_160_characters():
	"""Pages wrap near 140; tables, pictures, code and what commands write are as long as they are."""
	long = []
	for page in pages:
		text = re.sub(r"^<!--.*written by.*?^<!-- end", lambda block: "\n" * block.group().count("\n"), textOf(page), flags=re.S | re.M)
		text = re.sub(r"^```.*?^```", lambda block: "\n" * block.group().count("\n"), text, flags=re.S | re.M)
		for number, line in enumerate(text.splitlines(), 1):
			if len(line) > 160 and not line.lstrip().startswith(("|", "![")):
				long.append(f"{page.relative_to(root)}:{number}: {len(line)}")
	print(f"{len(pages)} pages, {len(long)} lines above 160 characters")
	assert not long


def test_the_picture_of_the_five_steps_shows_them_in_their_order():
	section = textOf(root / "CONTRIBUTING.md").split("### The five steps of the ground")[1].split("\n### ")[0]
	picture = re.search(r"^```\n(.*?)^```", section, re.S | re.M).group(1)
	steps = textOf(root / "pkg/mpm/README.md").split("## The five steps")[1].split("\n## ")[0]
	taken = list(dict.fromkeys(re.findall(r"^\| `(\w+)` \|", steps, re.M)))
	drawn = re.findall(r"\b(\d) (\w+)", picture)
	print(" -> ".join(name for _, name in drawn))
	assert drawn == [(str(number), name) for number, name in enumerate(taken, 1)]


def test_rooms_use_no_others_than_the_map_says_and_no_two_use_each_other():
	rows = re.findall(r"^\| \[pkg/(\w+)\]\([^)]*\) \| [^|]* \| ([^|]*)\|", textOf(root / "CONTRIBUTING.md"), re.M)
	told = {room: set(re.findall(r"\w+", re.sub(r"\(.*?\)", "", uses))) for room, uses in rows}
	found = {room: set() for room in told}
	for file, text in sources().items():
		room = file.relative_to(root).parts[1]
		if file.is_relative_to(root / "pkg"):
			found[room] |= {used for used in re.findall(r"^#\s*include <pkg/(\w+)/", text, re.M) if used in told and used != room}
	for room, used in found.items():
		print(f"{room} -> {', '.join(sorted(used)) or 'none'}")
	assert found == told
	order = []
	while len(order) < len(found):
		free = [room for room, used in found.items() if room not in order and used <= set(order)]
		assert free, f"a circle among {sorted(set(found) - set(order))}"
		order += free


def test_folders_of_the_ground_include_those_below_them_only():
	"""Effects and the thaw front need each other, and the settings of a ground its boundaries and laws; below them arrows go downwards."""
	below = {"grid": set(), "boundary": {"grid"}, "points": {"grid"}, "kernels": {"grid"}}
	found = {folder: set() for folder in below}
	for file, text in sources().items():
		folder = file.relative_to(root).parts[-2]
		if file.is_relative_to(root / "pkg/mpm") and folder in found:
			found[folder] |= {used for used in re.findall(r"^#\s*include <pkg/mpm/(\w+)/", text, re.M) if used != folder}
	for folder, used in found.items():
		print(f"mpm/{folder} -> {', '.join(sorted(used)) or 'none'}")
	assert found == below
