# SPDX-License-Identifier: Apache-2.0
"""One self-contained page: text, tables and pictures in a single file that asks for no other."""

import base64
import html
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
"""The page forbids its own browser every request."""

KINDS = {'.png': 'image/png', '.webp': 'image/webp', '.gif': 'image/gif'}

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 84rem; margin: 1.5rem auto;
       padding: 0 1rem; color: #1b1b1b; }
nav a { margin-right: 1rem; }
table { border-collapse: collapse; font-size: .83rem; margin: .8rem 0; display: block;
        overflow-x: auto; }
th, td { padding: .25rem .55rem; border-bottom: 1px solid #ddd; text-align: right;
         white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
thead th { border-bottom: 2px solid #555; }
figure { margin: 1rem 0; }
img { max-width: 100%; height: auto; }
figcaption { font-size: .85rem; color: #444; }
h2 { border-top: 1px solid #ccc; padding-top: .8rem; margin-top: 2rem; }
"""


@dataclass(frozen=True)
class Picture:
    """A picture file and what it shows, in a sentence."""

    path: Path
    caption: str


@dataclass(frozen=True)
class Section:
    """A heading with what belongs under it; the text is simple Markdown."""

    title: str
    text: str = ''
    pictures: Sequence[Picture] = ()


def html_report(title: str, sections: Sequence[Section]) -> str:
    """Return the page."""
    parts = ['<!doctype html>', '<html lang="en"><head><meta charset="utf-8">',
             f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
             '<meta name="viewport" content="width=device-width, initial-scale=1">',
             f'<title>{html.escape(title)}</title><style>{STYLE}</style></head><body>',
             f'<h1>{html.escape(title)}</h1>', '<nav>',
             *(f'<a href="#{_anchor(section.title)}">{html.escape(section.title)}</a>'
               for section in sections), '</nav>']
    for section in sections:
        parts += [f'<section><h2 id="{_anchor(section.title)}">{html.escape(section.title)}</h2>',
                  as_html(section.text), *map(_figure, section.pictures), '</section>']
    return '\n'.join([*parts, '</body></html>', ''])


def _anchor(title: str) -> str:
    return re.sub(r'\W+', '-', title.lower()).strip('-')


def _figure(picture: Picture) -> str:
    kind = KINDS[picture.path.suffix]
    data = base64.b64encode(picture.path.read_bytes()).decode()
    caption = html.escape(picture.caption)
    return (f'<figure><img alt="{caption}" src="data:{kind};base64,{data}">'
            f'<figcaption>{caption}</figcaption></figure>')


def as_html(text: str) -> str:
    """Return Markdown of headings, tables, lists and paragraphs as HTML."""
    made: list[str] = []
    for block in re.split(r'\n\s*\n', text.strip()):
        lines = block.splitlines()
        if not lines:
            continue
        if lines[0].startswith('|'):
            made.append(_table(lines))
        elif lines[0].startswith('- '):
            made.append('<ul>' + ''.join(f'<li>{_inline(line[2:])}</li>' for line in lines)
                        + '</ul>')
        elif lines[0].startswith('#'):
            level = min(len(lines[0]) - len(lines[0].lstrip('#')), 6)
            made.append(f'<h{level}>{_inline(lines[0].lstrip("# "))}</h{level}>')
        else:
            made.append(f'<p>{_inline(" ".join(lines))}</p>')
    return '\n'.join(made)


def _inline(text: str) -> str:
    return re.sub(r'`([^`]+)`', r'<code>\1</code>', html.escape(text, quote=False))


def _table(lines: Sequence[str]) -> str:
    def cells(line: str, tag: str) -> str:
        return ''.join(f'<{tag}>{_inline(cell.strip())}</{tag}>'
                       for cell in line.strip().strip('|').split('|'))
    body = ''.join(f'<tr>{cells(line, "td")}</tr>' for line in lines[2:])
    return (f'<table><thead><tr>{cells(lines[0], "th")}</tr></thead>'
            f'<tbody>{body}</tbody></table>')
