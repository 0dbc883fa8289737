"""The explorer: a page to look at a front, and to run searches from; and the same page as one file.

An **exhibit** is what the page shows: a search, a journey or a benchmark, as one JSON object, and the profiles of its
runs, one JSON object each. Exhibits come from the folders that commands wrote (`folder`), or from searches that the
page asked for, which child processes do (`compute`). The same page shows them in two ways: served (`server`), or with
one exhibit inside a single file (`standalone`); its files, HTML, CSS and modules, lie in ``page`` (`assets`).

Invariants: whatever comes through the network is parsed and computed in a child process with limits of memory and
time, never in the server's; no text from there becomes a path; nothing is written to disk. Units change in the page,
where numbers become text. starlette and uvicorn belong to `server`, which only ``tgvdp explore`` imports.
Start reading at `exhibit`, then `server.app`; in the page at ``main.js``.
"""
