"""Messages to the page, read as the page reads them."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest

from rodgen.view.live.frames import encode


def _decoded(message: bytes) -> tuple[dict[str, object], dict[str, np.ndarray]]:
    """By the rule alone: uint32, header, arrays from multiples of 8 bytes on."""
    (length,) = struct.unpack_from("<I", message)
    header = json.loads(message[4 : 4 + length])
    at, found = 4 + length, {}
    for name, kind, count in header.pop("arrays"):
        assert at % 8 == 0  # typed arrays of the browser need it
        size = {"f4": 4, "f8": 8}[kind]
        found[name] = np.frombuffer(message, f"<{kind}", count, at)
        at += -(-size * count // 8) * 8
    assert at == len(message)
    return header, found


@pytest.mark.parametrize("count", [0, 1, 2, 3, 101])
def test_what_goes_in_comes_out(count: int) -> None:
    single = np.linspace(-1, 1, count).astype(np.float32)
    double = np.linspace(0, 1e12, count)
    message = encode({"frame": 7, "texts": {"t": "1 µs"}}, [("a", single), ("plot:p1", double)])
    header, arrays = _decoded(message)
    assert header == {"frame": 7, "texts": {"t": "1 µs"}}
    assert np.array_equal(arrays["a"], single)
    assert np.array_equal(arrays["plot:p1"], double)


def test_not_a_number_goes_into_arrays_alone() -> None:
    _, arrays = _decoded(encode({"frame": 1}, [("a", np.array([np.nan, np.inf]))]))
    assert np.isnan(arrays["a"][0])
    assert np.isinf(arrays["a"][1])
    with pytest.raises(ValueError, match="not JSON compliant"):
        encode({"t": float("nan")}, [])


def test_no_address_of_another_server_is_in_the_components() -> None:
    import rodgen.view.live as home

    files = [p for p in Path(home.__path__[0]).rglob("*") if p.suffix in (".js", ".css", ".py")]
    assert any(p.suffix == ".js" for p in files)
    for path in files:
        text = path.read_text(encoding="utf-8")
        for scheme in ("http://", "https://", "//cdn", "wss://"):
            rest = text.replace('f"http://{', "").replace("http://www.w3.org/2000/svg", "")
            assert scheme not in rest, path
