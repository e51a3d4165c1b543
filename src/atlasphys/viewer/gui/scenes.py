"""Load and unload scenes, save the present world."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from atlasphys.errors import AtlasPhysError, SceneError
from atlasphys.scene import library
from atlasphys.viewer.gui.body_dialogs import PATIENCE
from atlasphys.viewer.gui.forms import Dialog, Form

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page


class Scenes:
    """The tab about scenes."""

    def __init__(self, page: Page) -> None:
        self._page = page
        gui = self._gui = page.server.gui
        self._library = gui.add_dropdown("Library", library.names(), initial_value="demo")
        self._about = gui.add_folder(None)
        self._parameters: Form | None = None
        self._show_parameters(None)
        self._library.on_update(self._show_parameters)
        gui.add_button("Load this scene", color="blue").on_click(lambda event: self._load(event.client))
        gui.add_button("Unload: only the ground").on_click(
            lambda event: self._then_fit(page.do(lambda session: session.unload(), event.client))
        )
        gui.add_divider()
        path = gui.add_text("Scene file", "", hint="A path on this computer, .toml or .json")
        gui.add_button("Load the file").on_click(
            lambda event: self._then_fit(page.do(lambda session: session.load(Path(path.value)), event.client))
        )
        upload = gui.add_upload_button("Choose a scene file…", mime_type=".toml,.json")
        upload.on_upload(self._uploaded)
        gui.add_button("Save the world…").on_click(lambda event: save_dialog(page, event.client))

    def _show_parameters(self, _: Any) -> None:
        """Fields for the parameters of the chosen scene."""
        entry, old = library.entry(self._library.value), self._about
        self._about = self._gui.add_folder(None, order=old.order)
        old.remove()
        with self._about:
            self._gui.add_markdown(entry.description)
            self._parameters = Form(self._gui)
            for name, field in entry.parameters.model_fields.items():
                self._parameters.from_schema(name, field, field.default)

    def _load(self, client: Any) -> None:
        name, parameters = self._library.value, self._parameters.values() if self._parameters else {}
        self._then_fit(self._page.do(lambda session: session.load(name, **parameters), client))

    def _uploaded(self, event: Any) -> None:
        file = event.target.value
        try:
            text = file.content.decode("utf-8-sig")
        except UnicodeDecodeError:
            self._page.say("Refused", f"{file.name}: is not UTF-8 text", event.client)
            return
        self._then_fit(self._page.do(lambda session: session.load_text(text, file.name), event.client))

    def _then_fit(self, future: Any) -> None:
        def done(_: Any) -> None:
            if future.exception() is None:
                self._page.select(None)
                self._page.cameras.fit_when_shown()

        future.add_done_callback(done)


def save_dialog(page: Page, client: Any) -> None:
    """Ask for a file and save the world as a scene."""
    with Dialog(client, "Save the world as a scene file") as dialog:
        form = Form(dialog.gui)
        form.text("path", "File", f"{page.frame.title}-saved.toml", "TOML, or JSON if it ends in .json")
        form.flag("replace", "Replace an existing file", False)

        def save() -> None:
            values = form.values()
            page.simulation.do(lambda session: session.save(values["path"], replace=values["replace"])).result(PATIENCE)

        def download() -> None:
            name = Path(form.values()["path"] or "scene.toml").name
            client.send_file_download(name, scene_bytes(page, name), save_immediately=True)

        dialog.buttons("Save", save, Download=download)


def scene_bytes(page: Page, name: str) -> bytes:
    """The present world as the contents of a scene file of that name.

    Raises:
        SceneError: it cannot be written.
    """
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        try:
            page.simulation.do(lambda session: session.save(path)).result(PATIENCE)
        except AtlasPhysError as error:
            raise SceneError(str(error)) from None
        return path.read_bytes()
