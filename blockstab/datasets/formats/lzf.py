"""LZF, the compression that point cloud files use (Marc Lehmann's LibLZF)."""

from __future__ import annotations

HIGHEST_RATIO = 88  # three bytes can stand for 264


def decompress(data: bytes, size: int) -> bytearray:
    """Undo LZF.

    A byte below 32 announces a run of so many bytes and one more. Any other starts a reference: its upper
    three bits and, if all are set, the next byte give the length less two; its lower five bits and the byte
    after that tell how far back it starts, less one.

    Args:
        data: the compressed bytes.
        size: how many bytes must come out; never many more are held.

    Raises:
        ValueError: the data is no LZF, or does not yield `size` bytes.
    """
    out = bytearray()
    at, end, held = 0, len(data), 0
    try:
        while at < end and held <= size:
            control = data[at]
            at += 1
            if control < 32:
                out += data[at : at + control + 1]
                at += control + 1
            else:
                length = (control >> 5) + 2
                if length == 9:
                    length += data[at]
                    at += 1
                start = held - ((control & 31) << 8) - data[at] - 1
                at += 1
                if start < 0:
                    raise ValueError("a reference starts before the data")
                piece = out[start : start + length]
                # A reference may run into what it writes itself, and then repeats.
                out += piece if len(piece) == length else (piece * (length // len(piece) + 1))[:length]
            held = len(out)
    except IndexError:
        raise ValueError("it ends within a reference") from None
    if at != end or held != size:
        raise ValueError(f"it does not yield the {size} bytes it should")
    return out
