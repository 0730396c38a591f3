"""Scenes and configurations of Tremolo as text (TOML), and motions as CSV. Nothing here needs Blender."""
import json


def value(thing):
    """A TOML value of a Python one."""
    if isinstance(thing, bool):
        return 'true' if thing else 'false'
    if isinstance(thing, str):
        return json.dumps(thing, ensure_ascii=False)
    if isinstance(thing, (list, tuple)):
        return '[' + ', '.join(value(item) for item in thing) + ']'
    if isinstance(thing, int):
        return str(thing)
    number = repr(float(thing))
    return number if set(number) & set('.en') else number + '.0'


def table(name, keys):
    """[[name]] and its keys; a list of dicts is a list of tables below it."""
    lines = [f'[[{name}]]'] if name else []
    below = []
    for key, thing in keys.items():
        if isinstance(thing, list) and thing and isinstance(thing[0], dict):
            below += [table(f'{name}.{key}' if name else key, item) for item in thing]
        else:
            lines.append(f'{key} = {value(thing)}')
    return '\n'.join(lines) + '\n' + ''.join('\n' + text for text in below)


def poses_csv(poses):
    """Rows t, x, y, z, qw, qx, qy, qz."""
    return ''.join(','.join(repr(float(number)) for number in row) + '\n' for row in poses)
