"""``tgvdp completion``: the script that teaches a shell to complete tgvdp's commands and options."""

import click

_EXAMPLES = """
\b
Examples:
  eval "$(tgvdp completion bash)"                in ~/.bashrc
  eval "$(tgvdp completion zsh)"                 in ~/.zshrc
  tgvdp completion fish > ~/.config/fish/completions/tgvdp.fish
"""


@click.command("completion", epilog=_EXAMPLES)
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@click.pass_context
def command(ctx: click.Context, shell: str) -> None:
    """Print the completion script of a shell."""
    from click.shell_completion import get_completion_class

    root = ctx.find_root()
    program = root.info_name or "tgvdp"
    completion = get_completion_class(shell)
    assert completion is not None  # click brings these three
    script = completion(root.command, {}, program, f"_{program.upper()}_COMPLETE").source()
    click.echo(script)
