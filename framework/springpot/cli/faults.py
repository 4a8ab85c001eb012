"""What ends a command: every error becomes one line on stderr and an exit code."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable

import click

from springpot.errors import LostStream, SpringpotError, blamed, described, plain_streams

# The last two as shells have them: 128 and the number of the signal.
BAD_INPUT, FAULT, INTERRUPTED, BROKEN_PIPE = 2, 3, 130, 141
TRACEBACK = "SPRINGPOT_TRACEBACK"


def exit_code(action: Callable[[], int]) -> int:
    """Run `action`; its exit code, or that of the error it ended in, which is told in one line.

    Nothing that is printed meanwhile can command the terminal.
    """
    with plain_streams():
        code = _exit_code(action)
    # Some library may have swallowed the KeyboardInterrupt; the handler remembers it.
    if _was_interrupted():
        return INTERRUPTED
    return code


def _was_interrupted() -> bool:
    """Whether Ctrl-C was pressed in this process, as its handler (`springpot.cli.CtrlC`) tells."""
    return getattr(signal.getsignal(signal.SIGINT), "pressed", False)


def _exit_code(action: Callable[[], int]) -> int:
    try:
        code = action()
        # Here, where a reader that has gone is still noticed as such.
        sys.stdout.flush()
        return code
    except SpringpotError as error:
        return _say(str(error), BAD_INPUT)
    except click.UsageError as error:
        return _say(_usage(error), BAD_INPUT)
    except click.ClickException as error:
        return _say(error.format_message(), BAD_INPUT)
    except (KeyboardInterrupt, click.Abort):
        return INTERRUPTED
    except BrokenPipeError:
        # The reader has gone; without this, Python complains when it flushes stdout on its way out.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return BROKEN_PIPE
    except LostStream as error:
        # What is still waiting to be written would fail again on the way out.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return _say(str(error.strerror), BAD_INPUT)
    # The last net: a user sees a line, never a traceback.
    except Exception as error:
        return _fault(error)


def _say(text: str, code: int) -> int:
    # A message of many lines, such as a library's, becomes one.
    print(f"springpot: {' '.join(text.split())}", file=sys.stderr)
    return code


def _usage(error: click.UsageError) -> str:
    """Click's message as one line, with the command whose help says more."""
    command = "springpot"
    if error.ctx:
        command = error.ctx.command_path
    if isinstance(error, click.exceptions.NoArgsIsHelpError) and isinstance(
        error.ctx.command, click.Group
    ):
        return (
            f"'{command}' needs one of {', '.join(error.ctx.command.commands)} (see '{command}"
            " --help')"
        )
    text = error.format_message().rstrip(".")
    return f"{text[:1].lower()}{text[1:]} (see '{command} --help')"


def _fault(error: Exception) -> int:
    if _was_interrupted():
        # What a half-imported library makes of Ctrl-C is no fault to be reported.
        return INTERRUPTED
    if os.environ.get(TRACEBACK):
        # Only for who asks: users see one line.
        import traceback

        traceback.print_exception(error)
        return FAULT
    if told := blamed(error):
        return _say(
            f"{told}: leave out what it offers, or uninstall it ({TRACEBACK}=1 shows more)",
            BAD_INPUT,
        )
    return _say(
        f"a fault in springpot or one of its plugins, not in your input: {described(error)} "
        f"(please report it with the traceback that {TRACEBACK}=1 shows)",
        FAULT,
    )
