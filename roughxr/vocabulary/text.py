"""Text of others' files, as it may be shown."""

import unicodedata

#: Categories of characters that move the cursor, colour or hide what is printed, or turn its direction.
_UNSEEN = {"Cc", "Cf", "Cs", "Co", "Zl", "Zp"}


def printable(text: str, *, keep: str = "") -> str:
    r"""Return text with control characters, such as those of a terminal, written out; ``keep`` are left as they are.

    Examples
    --------
    >>> print(printable("5 µm\x1b[2J\u202e"))
    5 µm\x1b[2J\u202e
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(one if one in keep or unicodedata.category(one) not in _UNSEEN else _written(one) for one in text)


def _written(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
