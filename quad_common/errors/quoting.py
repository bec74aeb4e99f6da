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

_LEFT_OUT = ' ... [left out] ... '

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
        Characters of the quotation, escapes counted as they are written.

    Returns
    -------
    str
        In single quotes, on one line; how long it was if it is not quoted whole.
    """
    # Escaped after it is cut: to escape ten million characters takes seconds.
    whole = escaped(text[: longest + 1])
    if len(whole) <= longest:
        return f"'{whole}'"
    return f"'{whole[:longest]}' ... ({len(text)} characters)"


def shown(value: object, longest: int = LONGEST_QUOTE) -> str:
    """Show a value of any type, as Python writes it, on one line and not too long."""
    if isinstance(value, str):
        return repr(value) if len(value) <= longest and value.isprintable() else quoted(value)
    if isinstance(value, int) and value.bit_length() > _LONGEST_INTEGER:
        return f'an integer of {value.bit_length()} bits'
    try:
        text = repr(value)
    except Exception as error:
        # Whatever else cannot be written must not hide what was wrong with it.
        return f'a {type(value).__name__} that cannot be shown ({type(error).__name__})'
    whole = escaped(text[: longest + 1])
    if len(whole) <= longest:
        return whole
    return f'{whole[:longest]} ... ({len(text)} characters)'


def clipped(sentence: str, longest: int = LONGEST_SENTENCE) -> str:
    """Return a sentence on one line; of one that is too long, its beginning and its end."""
    whole = escaped(sentence[: longest + 1])
    if len(whole) <= longest:
        return whole
    end = escaped(sentence[-_END:])[-_END:]
    return f'{whole[: longest - _END - len(_LEFT_OUT)]}{_LEFT_OUT}{end}'
