"""What a shell completes: names of the catalog and of instances, fields of trains and lines, files and folders."""

from typing import TYPE_CHECKING

import click

from tgvdp.constants import ENERGY_KINDS

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem


def complete_source(_: click.Context, parameter: click.Parameter, incomplete: str) -> "list[CompletionItem]":
    """Names of the catalog that the option takes, and files."""
    from tgvdp.model import catalog

    wanted = parameter.opts[0].removeprefix("--")
    kind = "map" if wanted == "energy" else wanted
    names = [name for one in catalog.KINDS if one == kind for name in catalog.names(one)]
    return _beginning(incomplete, [*names, *(ENERGY_KINDS if wanted == "energy" else ())], "file")


def complete_fields(_: click.Context, __: click.Parameter, incomplete: str) -> "list[CompletionItem]":
    """Fields of trains and lines."""
    from tgvdp.formats.native.changes import fields

    return _beginning(incomplete, [f"{name}=" for name in fields()])


def complete_instance(_: click.Context, __: click.Parameter, incomplete: str) -> "list[CompletionItem]":
    """Names of built-in instances, and files."""
    from tgvdp.instances import index

    return _beginning(incomplete, [*index()], "file")


def complete_name(_: click.Context, __: click.Parameter, incomplete: str) -> "list[CompletionItem]":
    """Names of all that is built in."""
    from tgvdp.instances import index
    from tgvdp.model import catalog

    return _beginning(incomplete, [*(name for kind in catalog.KINDS for name in catalog.names(kind)), *index()])


def complete_file(_: click.Context, __: click.Parameter, incomplete: str) -> "list[CompletionItem]":
    """Files."""
    return _beginning(incomplete, [], "file")


def complete_folder(_: click.Context, __: click.Parameter, incomplete: str) -> "list[CompletionItem]":
    """Folders."""
    return _beginning(incomplete, [], "dir")


def _beginning(incomplete: str, names: list[str], kind: str = "") -> "list[CompletionItem]":
    """Items for names that begin as what is written so far, and one that leaves files or folders to the shell."""
    from click.shell_completion import CompletionItem

    items = [CompletionItem(name) for name in names if name.startswith(incomplete)]
    return [*items, CompletionItem(incomplete, type=kind)] if kind else items
