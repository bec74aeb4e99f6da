"""
Who on the network can listen to and command this process, by the environment that ROS reads.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from quad_common.errors import QuadError
from quad_common.network.transport import DISCOVERY_SERVER, RANGE, is_bound_to_this_machine

_RANGES = {
    'SUBNET': 'every machine of this subnet',
    'LOCALHOST': 'this machine only',
    'OFF': 'this machine only, and only by an address that is given',
    'SYSTEM_DEFAULT': 'every participant that the middleware settings allow',
}
"""What each value of ROS_AUTOMATIC_DISCOVERY_RANGE means; the first is the default."""

_INSECURE = {
    # What each middleware says if a security is requested that it was built without.
    'rmw_fastrtps': b"doesn't have the security libraries",
    'rmw_cyclonedds': b'does not have security support enabled',
}


@dataclass(eq=False, repr=False)
class SecurityUnavailable(QuadError):
    """Security was requested, and what would give it is absent."""

    library: str
    """Middleware that was built without security."""

    def sentence(self) -> str:
        """Say what to do about it."""
        return (
            f'ROS_SECURITY_ENABLE is true, but {self.library} was built without security, as '
            'everything from PyPI is: nothing would be encrypted or signed; use a ROS 2 '
            'installation (docs/network.md), or unset ROS_SECURITY_ENABLE'
        )


@dataclass(eq=False, repr=False)
class SecuritySettingUnknown(QuadError):
    """A setting of ROS's security is none that ROS knows, so that it would start without."""

    name: str
    """Name of the environment variable."""
    value: str
    """Value that it has."""
    valid: str
    """Valid values, as the end of the sentence "it must be ..."."""

    def sentence(self) -> str:
        """Say what would be valid."""
        return (
            f"{self.name} is '{self.value[:50]}', which ROS does not recognize: it would start "
            f'without enforcing security; it must be {self.valid} (case-sensitive)'
        )


def reach_of(environment: Mapping[str, str]) -> str:
    """
    Say who is in reach.

    Parameters
    ----------
    environment : mapping of str to str
        The environment variables.

    Returns
    -------
    str
        One sentence with the domain, the range and the security.
    """
    domain = environment.get('ROS_DOMAIN_ID') or '0'
    peers = environment.get('ROS_STATIC_PEERS', '').strip('; ')
    security = 'security is off'
    if environment.get('ROS_SECURITY_ENABLE') == 'true':
        is_enforced = environment.get('ROS_SECURITY_STRATEGY') == 'Enforce'
        security = f'security is {"enforced" if is_enforced else "on where there are keys for it"}'
    given = environment.get(RANGE, '')
    server = environment.get(DISCOVERY_SERVER, '').strip('; ')
    if server:
        # Who asks a server for others finds nobody without it.
        reach = f'every participant that the server {server[:200]} knows'
        source = f'{DISCOVERY_SERVER} is set'
    elif environment.get('ROS_LOCALHOST_ONLY') == '1':
        # It is deprecated, and goes before the others.
        reach, source, peers = _RANGES['LOCALHOST'], 'ROS_LOCALHOST_ONLY=1', ''
    elif given == 'SYSTEM_DEFAULT' and is_bound_to_this_machine(environment):
        reach, source, peers = _RANGES['LOCALHOST'], "Fast DDS's settings", ''
    elif given in _RANGES:
        reach, source = _RANGES[given], f'{RANGE}={given}'
    elif given:
        reach, source = _RANGES['LOCALHOST'], f"{RANGE}='{given[:50]}' is no range that ROS knows"
    else:
        reach, source = next(iter(_RANGES.values())), f'{RANGE} is not set'
    if peers and given != 'OFF':
        reach += f', and with {peers[:200]}'
    return f'listening on domain {domain} to {reach} ({source}); {security}'


def check_security(
    environment: Mapping[str, str], library_without: Callable[[], str | None]
) -> None:
    """
    Refuse to start without the security that was requested.

    Parameters
    ----------
    environment : mapping of str to str
        The environment variables.
    library_without : callable
        Returns the name of the middleware in use if it was built without security.

    Raises
    ------
    SecurityUnavailable
        If it cannot be had.
    SecuritySettingUnknown
        If a setting is misspelt: ROS would take it for "no", and start without.
    """
    enable = environment.get('ROS_SECURITY_ENABLE', '')
    if enable not in ('', 'true', 'false'):
        raise SecuritySettingUnknown('ROS_SECURITY_ENABLE', enable, 'true or false')
    if enable != 'true':
        return
    strategy = environment.get('ROS_SECURITY_STRATEGY', '')
    if strategy not in ('', 'Enforce', 'Permissive'):
        raise SecuritySettingUnknown('ROS_SECURITY_STRATEGY', strategy, 'Enforce or Permissive')
    library = library_without()
    if library is not None:
        raise SecurityUnavailable(library)


def library_without_security(maps: Path = Path('/proc/self/maps')) -> str | None:
    """
    Find a middleware that was built without security among the libraries of this process.

    A middleware without security says so in an error, whose text is in its library; nothing
    else tells before a key is requested.

    Parameters
    ----------
    maps : Path
        What the process has loaded, as Linux lists it.

    Returns
    -------
    str or None
        The library's name; None if each has security, or if it cannot be known.
    """
    with contextlib.suppress(OSError):
        paths = {line.split()[-1] for line in maps.read_text().splitlines() if '.so' in line}
        for path in map(Path, sorted(paths)):
            for name, words in _INSECURE.items():
                if path.name.startswith(f'lib{name}') and words in path.read_bytes():
                    return name
    return None
