"""
Builds the documentation as a site.

``python tools/build_site.py`` assembles the pages where ``mkdocs.yml`` looks for them and builds
the site into ``build/site``. The pages keep the folders that they have here, and the files that
they link come along, so that one relative link serves the site, a code host and an editor.
"""

from __future__ import annotations

import argparse
import logging
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OUTPUT = ROOT / 'build'
PATTERNS = ('*.md', 'docs/**/*.md', 'msg_docs/*.md')
STYLE = ROOT / 'docs' / 'site.css'


def all_pages() -> list[Path]:
    """List the pages of the documentation, in order."""
    return sorted(path for pattern in PATTERNS for path in ROOT.glob(pattern))


def links(page: Path) -> Iterator[str]:
    """Yield the relative links of a page, outside its code."""
    text = re.sub(r'```.*?```|`[^`\n]*`', '', page.read_text(encoding='utf-8'), flags=re.DOTALL)
    for target in re.findall(r'\]\(([^)\s]+)\)|^\[\w+\]: (\S+)$', text, flags=re.MULTILINE):
        target = ''.join(target)
        if not re.match(r'[a-z]+:', target):
            yield target


def assemble(folder: Path) -> None:
    """
    Copy the pages, and the files that they link, into a folder.

    Parameters
    ----------
    folder : Path
        Where to; what was there is removed.
    """
    shutil.rmtree(folder, ignore_errors=True)
    wanted = {*all_pages(), STYLE}
    for page in all_pages():
        wanted |= {(page.parent / link.partition('#')[0]).resolve() for link in links(page)}
    for path in wanted:
        if path.is_file() and path.is_relative_to(ROOT):
            target = folder / path.relative_to(ROOT)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)


def build(output: Path) -> None:
    """
    Build the site; a link that leads nowhere, or a page that no menu has, is an error.

    Parameters
    ----------
    output : Path
        Folder that gets ``pages``, what is built from, and ``site``.

    Raises
    ------
    mkdocs.exceptions.Abort
        If there is anything to warn of.
    """
    from mkdocs.commands import build as mkdocs_build
    from mkdocs.config import load_config

    assemble(output / 'pages')
    config = load_config(
        str(ROOT / 'mkdocs.yml'),
        docs_dir=str(output / 'pages'),
        site_dir=str(output / 'site'),
        strict=True,
    )
    config.plugins.on_startup(command='build', dirty=False)
    try:
        mkdocs_build.build(config)
    finally:
        config.plugins.on_shutdown()


def main() -> None:
    """Build the site."""
    parser = argparse.ArgumentParser(description='Build the documentation as a site.')
    parser.add_argument('--output', type=Path, default=OUTPUT, help='folder for pages and site')
    output = parser.parse_args().output.resolve()
    try:
        import material  # noqa: F401
        from mkdocs.exceptions import Abort
    except ModuleNotFoundError:
        sys.exit("this needs mkdocs-material: make site, or pip install 'quadwalk[docs]'")
    logging.basicConfig(level=logging.WARNING, format='%(message)s')
    try:
        build(output)
    except Abort as error:
        sys.exit(str(error))
    print(f'site: {output / "site" / "index.html"}')


if __name__ == '__main__':
    main()
