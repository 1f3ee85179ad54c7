"""The playground that comes with the package."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pneumatic_servo as ps
import pytest
from pneumatic_servo import playground


def test_play_opens_the_page_in_the_browser(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    page = ps.play()
    assert opened == [page.as_uri()]
    assert page.stat().st_size > 1_000_000


def test_play_only_names_the_page_where_no_browser_is_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(webbrowser, "open", lambda address: pytest.fail(f"opens {address}"))
    assert ps.play(browser=False).is_file()


def test_a_package_without_the_page_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(playground, "PAGE", tmp_path / "index.html")
    with pytest.raises(FileNotFoundError, match="built without the playground"):
        ps.play()
