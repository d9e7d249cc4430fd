"""The settings of a gateway as a table: key, option, variable, default and meaning."""

from openrois.gateway.configuration import Setting, settings_of

__all__ = ["gateway_settings"]


def gateway_settings() -> list[str]:
    """Return a heading and a table for each table of the configuration file."""
    lines: list[str] = []
    table = ""
    for setting in settings_of():
        if setting.table != table:
            table = setting.table
            lines += ["", f"### `[{table}]`", "", "| key and option | default | meaning |", "|---|---|---|"]
        lines.append(f"| `{setting.key}`<br>`{setting.option}` | {_default(setting)} | {setting.meaning} |")
    return lines[1:]


def _default(setting: Setting) -> str:
    default = setting.info.default
    return "" if default in (None, (), "") or setting.is_secret else f"`{str(default).lower()}`"
