"""The playground: the plant in a browser, in one page that comes with the package."""

from __future__ import annotations

import webbrowser
from pathlib import Path

PAGE = Path(__file__).parent / "playground_files" / "index.html"


def play(browser: bool = True) -> Path:
    """Open the playground: the same plant, live in your browser.

    The page needs no network and no server. It runs the plant as WebAssembly, with the bits of this package.

    Parameters
    ----------
    browser : bool
        Whether to open the page; otherwise it is only named.

    Returns
    -------
    pathlib.Path
        The page inside the package.

    Raises
    ------
    FileNotFoundError
        When the package was built without the page.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> ps.play(browser=False).name
    'index.html'
    """
    if not PAGE.is_file():
        raise FileNotFoundError("this package was built without the playground; `cargo xtask wheel` says why")
    if browser:
        webbrowser.open(PAGE.as_uri())
    return PAGE
