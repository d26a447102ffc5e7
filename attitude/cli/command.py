"""The command `attitude`: its parser, and the commands that only list scenes or start the service.

Bad input is one line on standard error and exit code 2.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from typing import NoReturn

from ..errors import AttitudeError, suggestion
from ..version import __version__
from .console import warnings_on_one_line

BAD_INPUT = 2  # exit code
# The module of each command, and one line about it; a module is imported for its own command only.
COMMANDS = {
    "run": ("run", "simulate a scene"),
    "convert": ("convert", "turn a file of attitudes into one of another format or frame"),
    "check": ("check", "tell what is off in a file of attitudes"),
    "compare": ("compare", "tell how two files of attitudes differ"),
    "fit": ("fit", "the motion of a free body from observations"),
    "plan": ("plan", "tell what a run would simulate, and how"),
    "plot": ("plot", "draw a scene's attitude in time"),
    "windows": ("windows", "find when an axis sees a target, or the body is in shadow"),
    "cost": ("costs", "what accuracy costs in time, on a scene"),
    "ensemble": ("ensemble", "many bodies: statistics of their attitudes, or all of them stored"),
    "scenes": ("", "list the built-in scenes, or print one"),
    "serve": ("", "serve over HTTP"),
    "completion": ("", "print what makes a shell complete commands and options"),
    "help": ("", "explain a command"),
}
# Flags of `attitude serve`: settings of the service by their names, which judges their values itself.
SERVING = {
    "host": ("H", "address to listen at (ATTITUDE_HOST; 127.0.0.1)"),
    "port": ("N", "port to listen at (ATTITUDE_PORT; 8000)"),
    "workers": ("N", "processes that answer (ATTITUDE_WORKERS; 1)"),
    "threads": (
        "N",
        "threads of each that compute (ATTITUDE_THREADS; the processors, shared among the workers)",
    ),
    "max_requests": ("N", "requests that each computes or keeps waiting (ATTITUDE_MAX_REQUESTS)"),
    "max_samples": ("N", "instants that one answer may hold (ATTITUDE_MAX_SAMPLES; 1000000)"),
    "max_effects": ("N", "effects that one scene may name (ATTITUDE_MAX_EFFECTS; 100)"),
    "max_seconds": ("S", "seconds of computing that one request may need (ATTITUDE_MAX_SECONDS; 30)"),
    "max_body_bytes": ("N", "bytes that a document may have (ATTITUDE_MAX_BODY_BYTES; 4194304)"),
    "token_file": ("FILE", "file with the bearer token that requests have to bring (ATTITUDE_TOKEN_FILE)"),
    "cors_origins": ("LIST", "origins whose pages may ask (ATTITUDE_CORS_ORIGINS; none)"),
    "log_level": ("LEVEL", "debug, info, warning or error (ATTITUDE_LOG_LEVEL; info)"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit code."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if arguments[:1] in ([], ["help"]):
        arguments = [*arguments[1:2], "--help"]
    try:
        options = parser(*arguments[:1]).parse_args(list(_joined(arguments)))
        with warnings_on_one_line():
            code = options.execute(options)
            sys.stdout.flush()
    except AttitudeError as error:
        print("attitude: " + " ".join(str(error).splitlines()), file=sys.stderr)
        return BAD_INPUT
    except BrokenPipeError:  # the reader of a pipe has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt as error:
        if not error.args:  # a command that leaves something to go on from has said so
            print("attitude: interrupted", file=sys.stderr)
        return 130  # as shells have it
    else:
        return code or 0
    return 0


def _joined(arguments: Sequence[str]) -> Iterator[str]:
    """The arguments, with values that begin with "-", such as the axis -z, joined to their options."""
    pending = ""
    for argument in arguments:
        is_value = pending and argument.startswith("-") and not argument.startswith("--")
        if pending and not is_value:
            yield pending
        word = f"{pending}={argument}" if is_value else argument
        pending = word if word in ("--axis", "--to", "--above-plane") else ""
        if not pending:
            yield word
    if pending:
        yield pending


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """One line, without the usage that argparse puts before it; with the word that was meant."""
        if word := re.search(r"unrecognized arguments: (-[^ =]+)|invalid choice: '([^']*)'", message):
            message += suggestion(word[1] or word[2], self.words())
        self.exit(BAD_INPUT, f"attitude: {message} (see {self.prog} --help)\n")

    def words(self) -> Iterator[str]:
        """Words that complete a line: options, choices of arguments, and the same of commands."""
        for action in self.actions():
            yield from (*action.option_strings, *map(str, action.choices or ()))

    def actions(self) -> Iterator[argparse.Action]:
        """Options and arguments of a parser, and those of its commands."""
        for action in self._actions:
            yield action
            for command in action.choices.values() if isinstance(action.choices, Mapping) else ():
                yield from command.actions()


def parser(*commands: str) -> _Parser:
    """The parser of the command line, with the arguments of these commands."""
    whole = _Parser(prog="attitude", description="Exact attitude ephemerides of freely rotating bodies.")
    whole.add_argument("-V", "--version", action="version", version=f"attitude {__version__}")
    parsers = whole.add_subparsers(required=True, metavar="COMMAND")
    for name, (module_name, text) in COMMANDS.items():
        of_command = parsers.add_parser(name, help=text)
        if name not in commands:
            continue
        if name == "scenes":
            of_command.add_argument("name", nargs="?", metavar="NAME", help="print this scene's document")
            of_command.set_defaults(execute=_scenes)
        elif name == "completion":
            of_command.add_argument(
                "shell", choices=("bash", "zsh", "fish", "tcsh"), help="source what is printed, or save it"
            )
            of_command.set_defaults(execute=_completion)
        elif name == "help":
            of_command.add_argument("command", nargs="?", metavar="COMMAND")
        elif name == "serve":
            for setting, (metavar, meaning) in SERVING.items():
                of_command.add_argument(f"--{setting.replace('_', '-')}", metavar=metavar, help=meaning)
            of_command.set_defaults(execute=_serve)
        else:
            module = import_module(f".{module_name}", __package__)
            module.add_arguments(of_command)
            of_command.set_defaults(execute=module.execute)
    return whole


def complete_parser() -> _Parser:
    """The parser with the arguments of all commands, for the reference and for shells that complete words."""
    return parser(*COMMANDS)


def _scenes(options: argparse.Namespace) -> None:
    from ..scene.builtin_scenes import builtin_names
    from ..scene.scene import Scene

    if options.name is not None:
        print(Scene.builtin(options.name).to_json())
        return
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else sys.maxsize
    column = max(map(len, builtin_names())) + 2
    for name in builtin_names():
        scene = Scene.builtin(name)
        text = f"{scene.name}. {scene.description}"
        first, other = f"{name:<{column}}", " " * column
        print(textwrap.fill(text, max(width, 60), initial_indent=first, subsequent_indent=other))


def _completion(options: argparse.Namespace) -> None:
    try:
        import shtab
    except ModuleNotFoundError as error:
        raise AttitudeError(f"completion needs {error.name}: pip install 'attitude[completion]'") from None
    whole = complete_parser()
    for action in whole.actions():
        if action.metavar in ("FILE", "SCENE", "DOCUMENT", "DIRECTORY", "A", "B"):
            action.complete = shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(whole, options.shell))


def _serve(options: argparse.Namespace) -> None:
    try:
        from service import serve
    except ModuleNotFoundError as error:
        if error.name in ("fastapi", "uvicorn", "starlette", "h11", "prometheus_client", "pydantic_settings"):
            message = f"the service needs {error.name}: pip install 'attitude[service]'"
            raise AttitudeError(message) from None
        raise
    serve(**{name: getattr(options, name) for name in SERVING})


if __name__ == "__main__":
    sys.exit(main())
