"""
Expands one xacro file, in a process of its own and within bounds.

A few characters of an expression, or ten lines of macros, can ask for any time and any memory, and
no signal interrupts what Python computes in one go.
"""

from __future__ import annotations

import contextlib
import json
import resource
import sys

LONGEST = 20
"""Processor time for a file [s]; large descriptions of robots take a tenth of one."""

_MOST_MEMORY = 2**32
"""Bytes of address space."""

_LIMITS = ((resource.RLIMIT_CPU, LONGEST), (resource.RLIMIT_AS, _MOST_MEMORY))


def main() -> None:
    """Take a path and the values of arguments; print the XML, or the error and its kind."""
    path, mappings = json.loads(sys.argv[1])
    for limit, most in _LIMITS:
        hard = resource.getrlimit(limit)[1]
        is_lower = hard == resource.RLIM_INFINITY or most < hard
        resource.setrlimit(limit, (most if is_lower else hard, hard))
    answer = sys.stdout
    # Whatever is printed meanwhile is none.
    with contextlib.redirect_stdout(sys.stderr):
        import xacro

        try:
            result = {'text': xacro.process_file(path, mappings=mappings).toxml()}
        # xacro evaluates what the file says, and lets pass whatever that raises.
        except (Exception, SystemExit) as error:
            result = {'error': str(error), 'kind': type(error).__name__}
    json.dump(result, answer)


if __name__ == '__main__':
    main()
