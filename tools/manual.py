#!/usr/bin/env python3
"""Write the manual page of hampm, or what completes its command line in a shell, from what `hampm --help` and `hampm --keys` print.

    tools/manual.py PROGRAM man      a page for man(1)
    tools/manual.py PROGRAM bash     completion for bash: options, keys of --set and the values that they allow, files
    tools/manual.py PROGRAM zsh      the same for zsh

It needs no packages.
"""

import argparse
import re
import subprocess
from pathlib import Path

FILES = {"--output": "folder", "--resume": "checkpoint"}  # options whose values are files; others that take values complete nothing


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", metavar="PROGRAM", type=Path)
    parser.add_argument("kind", choices=KINDS)
    options = parser.parse_args()
    print(KINDS[options.kind](Reference(options.program.resolve())), end="")


class Reference:
    """What the program says of itself.

    version     in words
    usage       lines: how it is called
    about       what it does
    options     (name, name of its value or '', meaning)
    exit_codes  what they mean
    groups      name -> (what it is, {key: (kind of value, unit, default, allowed, meaning)})
    """

    def __init__(self, program):
        def said(option):
            return subprocess.run([program, option], check=True, capture_output=True, text=True).stdout
        self.version = said("--version").strip()
        usage, about, options, exit_codes = re.fullmatch(r"Usage: (.*?)\n\n(.*?)\n\n(.*?)\n\nExit codes: (.*)", said("--help"), re.DOTALL).groups()
        self.usage = [line.strip() for line in usage.splitlines()]
        self.about, self.exit_codes = " ".join(about.split()), " ".join(exit_codes.split())
        self.options = [(name, value or "", meaning) for name, value, meaning
                        in re.findall(r"^  (--[\w-]+)(?: (\S+))?  +(.*)$", options, re.MULTILINE)]
        self.groups = {}
        for name, text in re.findall(r"^## &(\w+)\n(.*?)(?=^## &|\Z)", said("--keys"), re.MULTILINE | re.DOTALL):
            rows = re.findall(r"^\| `(\w+)` \| (.*?) \| (.*?) \| (.*?) \| (.*?) \| (.*) \|$", text, re.MULTILINE)
            self.groups[name] = text.split("```")[0].strip(), {key: row for key, *row in rows}

    def values(self):
        """GROUP.KEY -> the names that are allowed as values; none for numbers and free texts."""
        return {f"{group}.{key}": re.findall(r"`([^`]+)`", row[3]) for group, (_, keys) in self.groups.items() for key, row in keys.items()}


# --- man ----------------------------------------------------------------------------------------------------------------

def roff(text):
    """Text as roff has it: of Markdown remain the words."""
    text = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", " ".join(text.split())).replace("`", "").replace("**", "")
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return f"\\&{text}" if text.startswith((".", "'")) else text


def manual_page(reference):
    """The page: how it is called, options, exit codes, groups and keys."""
    lines = [f'.TH HAMPM 1 "" "{roff(reference.version)}" "User Commands"', ".SH NAME",
             "hampm \\- dynamic energy release rates of cracks by the material point method", ".SH SYNOPSIS"]
    for usage in reference.usage:
        lines += [".B " + roff(usage), ".br"]
    lines += [".SH DESCRIPTION", roff(reference.about), ".SH OPTIONS"]
    for name, value, meaning in reference.options:
        lines += [".TP", f"\\fB{roff(name)}\\fR" + (f" \\fI{roff(value)}\\fR" if value else ""), roff(meaning)]
    lines += [".SH EXIT STATUS", roff(reference.exit_codes), ".SH GROUPS AND KEYS",
              "A model is a Fortran namelist file of these groups; \\fB\\-\\-template\\fR prints a whole one. Units are SI."]
    for group, (about, keys) in reference.groups.items():
        lines += [f".SS &{group}", roff(about)]
        for key, (kind, unit, default, allowed, meaning) in keys.items():
            words = [kind, *([f"[{unit}]"] if unit else []), f"default: {default}", *([f"allowed: {allowed}"] if allowed else [])]
            lines += [".TP", f"\\fB{roff(key)}\\fR ({roff('; '.join(words))})", roff(meaning)]
    return "\n".join(lines) + "\n"


# --- shells -------------------------------------------------------------------------------------------------------------

def cases(reference):
    """Lines of a shell's `case` that set `values` to the names that a key allows."""
    return "\n".join(f"        {key}) values='{' '.join(names)}' ;;" for key, names in reference.values().items() if names)


def bash(reference):
    """A file for bash-completion, which works without that package as well. `=` may separate words (COMP_WORDBREAKS)."""
    takes_value = "|".join(name for name, value, _ in reference.options if value and name != "--set" and name not in FILES)
    return f"""# Completion of hampm for bash, made from what `hampm --help` and `hampm --keys` of {reference.version} print.

_hampm_values() {{
    local values=
    case $1 in
{cases(reference)}
    esac
    COMPREPLY=($(compgen -W "$values" -- "$2"))
}}

_hampm() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} key=
    COMPREPLY=()
    if [[ $word == = ]]; then
        key=$before word=
    elif [[ $before == = ]]; then
        key=${{COMP_WORDS[COMP_CWORD - 2]}}
    elif [[ $word == *=* && $before == --set ]]; then
        key=${{word%%=*}}
        _hampm_values "$key" "${{word#*=}}"
        COMPREPLY=("${{COMPREPLY[@]/#/$key=}}")
        return
    fi
    case $key in
        --*) before=$key ;;
        ?*)
            _hampm_values "$key" "$word"
            return ;;
    esac
    case $before in
        --set)
            compopt -o nospace 2>/dev/null
            COMPREPLY=($(compgen -S = -W '{' '.join(reference.values())}' -- "$word")) ;;
        --output)
            compopt -o filenames 2>/dev/null
            mapfile -t COMPREPLY < <(compgen -d -- "$word") ;;
        --resume)
            compopt -o filenames 2>/dev/null
            mapfile -t COMPREPLY < <(compgen -f -X '!*.checkpoint' -- "$word"; compgen -d -- "$word") ;;
        {takes_value}) ;;
        *)
            if [[ $word == -* ]]; then
                COMPREPLY=($(compgen -W '{' '.join(name for name, _, _ in reference.options)}' -- "$word"))
            else
                compopt -o filenames 2>/dev/null
                mapfile -t COMPREPLY < <(compgen -f -X '!*.nml' -- "$word"; compgen -d -- "$word")
            fi ;;
    esac
}}

complete -F _hampm hampm
"""


def zsh(reference):
    """A file of a folder in zsh's fpath."""
    lines = []
    for name, value, meaning in reference.options:
        said = meaning.replace("'", "'\\''").replace("[", "\\[").replace("]", "\\]").replace(":", "\\:")
        action = {"folder": "_files -/", "checkpoint": "_files -g \"*.checkpoint\""}.get(FILES.get(name), "_hampm_setting" if name == "--set" else "")
        behind = f":{value.lower().replace('=', ' ')}:{action}" if value else ""
        lines.append(f"    '{'*' * (name == '--set')}{name}[{said}]{behind}' \\")
    keys = "\n".join(f"    {key}" for key in reference.values())
    return f"""#compdef hampm
# Completion of hampm for zsh, made from what `hampm --help` and `hampm --keys` of {reference.version} print.

_hampm_setting() {{
    local values=
    local -a keys
    keys=(
{keys}
    )
    if compset -P '*='; then
        case ${{${{IPREFIX%=}}##*[[:space:]]}} in
{cases(reference)}
        esac
        compadd -- ${{=values}}
    else
        compadd -S = -- $keys
    fi
}}

_arguments \\
{chr(10).join(lines)}
    '1:model:_files -g "*.nml"'
"""


KINDS = {"man": manual_page, "bash": bash, "zsh": zsh}

if __name__ == "__main__":
    main()
