"""
The site of the documents has every page, builds without a warning, and needs no other host.
"""

from __future__ import annotations

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
import yaml
from test_docs import PAGES, ROOT, relative

TOOL = ROOT / 'tools' / 'build_site.py'
PARTS = ['First hour', 'How to', 'Reference', 'Theory', 'Results']
COUNTED = ('h1', 'h2', 'h3', 'ul', 'ol', 'li', 'pre', 'table', 'tr', 'td', 'a', 'img', 'code')


def menu() -> list[Any]:
    """Return the menu of ``mkdocs.yml``."""
    return yaml.safe_load((ROOT / 'mkdocs.yml').read_text(encoding='utf-8'))['nav']


def places(entry: Any) -> list[str]:
    """List the pages of an entry of the menu."""
    if isinstance(entry, str):
        return [entry]
    below = entry.values() if isinstance(entry, dict) else entry
    return [page for part in below for page in places(part)]


class Tags(HTMLParser):
    """The tags of a page, and what a browser loads for it by itself."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.names: list[str] = []
        self.loaded: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.append(tag)
        given = dict(attrs)
        loads = tag != 'link' or given.get('rel') in ('stylesheet', 'icon', 'preconnect', 'preload')
        if tag != 'a' and loads:
            self.loaded += filter(None, (given.get('src'), given.get('href')))


@pytest.fixture(scope='module')
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the site was built."""
    pytest.importorskip('material', reason='mkdocs-material is not installed: make site')
    folder = tmp_path_factory.mktemp('documents')
    built = subprocess.run(
        [sys.executable, str(TOOL), '--output', str(folder)],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    return folder / 'site'


def test_the_menu_has_five_parts_and_every_page_once():
    assert [name for part in menu() for name in part] == PARTS
    assert sorted(places(menu())) == sorted(map(relative, PAGES))


def test_the_site_has_every_page(site):
    pages = {relative(page).replace('README.md', 'index.md') for page in PAGES}
    assert [page for page in pages if not (site / page).with_suffix('.html').is_file()] == []


def test_the_site_loads_nothing_from_other_hosts(site):
    for page in site.rglob('*.html'):
        loaded = Tags(page.read_text(encoding='utf-8')).loaded
        assert loaded
        assert [place for place in loaded if re.match(r'(\w+:)?//', place)] == [], page
    for sheet in site.rglob('*.css'):
        assert not re.search(r'(url\(|@import)\W*(https?:)?//', sheet.read_text(encoding='utf-8'))


@pytest.mark.parametrize('page', PAGES, ids=relative)
def test_the_site_reads_a_page_as_code_hosts_do(page):
    markdown = pytest.importorskip('markdown', reason='mkdocs-material is not installed: make site')
    host = pytest.importorskip('markdown_it').MarkdownIt('commonmark').enable('table')
    text = page.read_text(encoding='utf-8')
    extensions = ['tables', 'sane_lists', 'fenced_code']
    read = [
        Tags(markdown.markdown(text, extensions=extensions)).names,
        Tags(host.render(text)).names,
    ]
    ours, theirs = ({tag: names.count(tag) for tag in COUNTED} for names in read)
    assert ours == theirs
