"""
Quoting what was received: sentences stay short and on one line, whatever it holds.
"""

from __future__ import annotations

LONGEST_QUOTE = 200
"""Characters that are quoted of what was received."""

LONGEST_SENTENCE = 500
"""Characters of a sentence in a log, on a topic or in an answer."""

_END = 150
"""Characters kept of the end of a sentence that is too long: it says what would be valid."""

_LONGEST_INTEGER = 512
"""Bits of an integer that is written out: Python refuses to write some thousand digits."""


def escaped(text: str) -> str:
    """Return a text with its control characters, line ends and lone surrogates escaped."""
    if text.isprintable():
        return text
    return ''.join(
        c if c.isprintable() else c.encode('unicode_escape', 'surrogatepass').decode() for c in text
    )


def quoted(text: str, longest: int = LONGEST_QUOTE) -> str:
    """
    Quote a text that was received.

    Parameters
    ----------
    text : str
        Any text, of any length.
    longest : int
        Characters of it that are quoted.

    Returns
    -------
    str
        In single quotes, on one line; how long it was if it is not quoted whole.
    """
    if len(text) <= longest:
        return f"'{escaped(text)}'"
    return f"'{escaped(text[:longest])}' ... ({len(text)} characters)"


def shown(value: object, longest: int = LONGEST_QUOTE) -> str:
    """Show a value of any type, as Python writes it, on one line and not too long."""
    if isinstance(value, str):
        return repr(value) if len(value) <= longest else quoted(value, longest)
    if isinstance(value, int) and value.bit_length() > _LONGEST_INTEGER:
        return f'an integer of {value.bit_length()} bits'
    try:
        text = repr(value)
    except Exception as error:
        # Whatever else cannot be written must not hide what was wrong with it.
        return f'a {type(value).__name__} that cannot be shown ({type(error).__name__})'
    if len(text) <= longest:
        return escaped(text)
    return f'{escaped(text[:longest])} ... ({len(text)} characters)'


def clipped(sentence: str, longest: int = LONGEST_SENTENCE) -> str:
    """Return a sentence on one line; of one that is too long, its beginning and its end."""
    if len(sentence) <= longest:
        return escaped(sentence)
    left_out = len(sentence) - longest
    begin, end = sentence[: longest - _END], sentence[-_END:]
    return f'{escaped(begin)} ... ({left_out} characters left out) ... {escaped(end)}'
