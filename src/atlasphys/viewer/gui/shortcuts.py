"""Keys, and the panel that lists them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from atlasphys.viewer.gui.joint_dialog import join_dialog

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page

OWN_KEYS = (
    ("W A S D Q E", "fly: forward, left, back, right, down, up"),
    ("arrow keys", "turn the camera"),
    ("Ctrl K", "search all commands"),
)
"""Keys of the page itself."""


def add_shortcuts(page: Page) -> None:
    """Register the keys as commands, and list them."""
    gui = page.server.gui
    rows = []
    for key, label, action in _commands(page):
        command = gui.add_command(label, hotkey=key)
        command.on_trigger(lambda event, action=action: action(event.client))
        rows.append((key.upper() if len(key) == 1 else key.capitalize(), label))
    lines = "\n".join(f"| {key} | {label} |" for key, label in (*rows, *OWN_KEYS))
    gui.add_markdown(f"| key | what it does |\n|---|---|\n{lines}")
    gui.add_markdown(
        "Keys act while no field is being typed in. Click on a body, or on a line of a joint, to select it. "
        "Numbers that the world refuses are refused with the reason; nothing is changed then."
    )


def _commands(page: Page) -> list[tuple[str, str, Callable[[Any], Any]]]:
    """Key, label and action of each."""

    def toggle(name: str) -> Callable[[Any], Any]:
        return lambda client: page.show.toggle(name)

    def select_nothing() -> None:
        page.select(None)
        page.select_joint(None)

    def delete(client: Any) -> None:
        no_body = page.selected is None and page.selected_joint is not None
        page.joints.act("Remove joint", client) if no_body else page.objects.act("Delete", client)

    cameras = page.cameras
    common: list[tuple[str, str, Callable[[Any], Any]]] = [
        ("F", "Camera near the selected body, following it, or back", cameras.toggle_close_up),
        ("K", "Close-up of the selected body in a window, on or off", page.close_ups.toggle),
        ("O", "Orthographic or perspective", cameras.toggle_projection),
        ("escape", "Select nothing", lambda client: select_nothing()),
        ("G", "Grid on or off", toggle("grid")),
        ("P", "Planes on or off", toggle("plane")),
        ("V", "Velocity arrows on or off", toggle("velocity")),
        ("M", "Mass × acceleration arrows on or off", toggle("force")),
        ("L", "Dark or light", toggle("dark")),
        ("1", "View from the front", lambda client: cameras.look(client, "front")),
        ("2", "View from the right", lambda client: cameras.look(client, "right")),
        ("3", "View from the top", lambda client: cameras.look(client, "top")),
        ("4", "Oblique view", lambda client: cameras.look(client, "oblique")),
    ]
    if "impulse" in page.show.switches:
        common += [
            ("I", "Contact impulse arrows on or off", toggle("impulse")),
            ("J", "Contact points on or off", toggle("contacts")),
        ]
    if page.is_replay:
        return [
            ("space", "Play or pause", page.transport.toggle),
            ("N", "Next step", lambda client: page.do(lambda replay: replay.step(1), client)),
            ("B", "Step before", lambda client: page.do(lambda replay: replay.step(-1), client)),
            ("R", "To the beginning", lambda client: page.do(lambda replay: replay.seek(0), client)),
            *common,
        ]
    return [
        ("space", "Start or stop", page.transport.toggle),
        ("N", "Next step", lambda client: page.do(lambda session: session.step(), client)),
        ("B", "Step back", lambda client: page.do(lambda session: session.step_back(), client)),
        ("R", "Reset", lambda client: page.do(lambda session: session.reset(), client)),
        ("C", "Add a cube", lambda client: page.objects.quick_add("cube", client)),
        ("X", "Add a sphere", lambda client: page.objects.quick_add("sphere", client)),
        ("T", "Shoot a ball from the camera", cameras.shoot),
        ("U", "Join the two bodies selected last, by a dialog", lambda client: join_dialog(page, client)),
        ("delete", "Delete the selected body, or else joint", delete),
        *common,
    ]
