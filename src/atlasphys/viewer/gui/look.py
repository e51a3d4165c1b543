"""How the page looks where its own interface has no setting: true colours, shadows over the whole scene, a background, tabs in one
row, joints in front of bodies.

A snippet in the page sets them, on objects that viser keeps for its own tests. Where these are not there, the page is paler and has no shadows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from atlasphys.viewer.colours import BACKGROUND
from atlasphys.viewer.frame import Frame
from atlasphys.viewer.sun import DIRECTION

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page

SHADOW_PIXELS = 2048
"""Of the map of shadows."""

CHANGE = 1.3
"""Factor by which the radius of the scene changes before shadows are fitted anew."""

STYLE = """<style>
canvas[data-engine] { background: rgb(BACKGROUND); }
[role="tab"] { padding-left: 0.55em !important; padding-right: 0.55em !important; min-width: 0 !important; }
</style>"""

SUN = """<img src="data:," style="display:none" onerror="window.__atlasSun = [X, Y, Z, RADIUS];
window.__atlasLook = window.__atlasLook || setInterval(function () {
  const viser = window.__viserMutable, sun = window.__atlasSun, scene = viser && viser.scene;
  const root = scene && scene.__r3f && scene.__r3f.root;
  if (!root) return;
  const page = root.getState();
  if (page.gl.toneMapping) { page.gl.toneMapping = 0; viser.requestRender(); }
  scene.traverse(function (light) {
    if (!light.isDirectionalLight || light.__atlas === sun) return;
    light.__atlas = sun;
    light.castShadow = sun[3] > 0;
    const r = sun[3] || 1, shadow = light.shadow, camera = shadow.camera;
    light.position.set(sun[0] + 2 * r * TOX, sun[1] + 2 * r * TOY, sun[2] + 2 * r * TOZ);
    light.target.position.set(sun[0], sun[1], sun[2]);
    light.target.updateMatrixWorld();
    camera.left = camera.bottom = -r; camera.right = camera.top = r; camera.near = 0.2 * r; camera.far = 4 * r;
    camera.updateProjectionMatrix();
    shadow.mapSize.set(PIXELS, PIXELS); shadow.bias = -0.0004; shadow.normalBias = 1.5 * r / PIXELS; shadow.radius = 2.5;
    viser.requestRender(); }); }, 150)">"""


ON_TOP = """<img src="data:," style="display:none" onerror="window.__atlasJoints = window.__atlasJoints || setInterval(function () {
  const nodes = (window.__viserMutable || {}).nodeRefFromName || {};
  for (const name in nodes) if (/^.overlays.(joint |centers)/.test(name) && nodes[name]) nodes[name].traverse(function (one) {
    if (one.material && one.material.depthTest) {
      one.material.depthTest = false; one.material.transparent = true; one.renderOrder = /selected$/.test(name) ? 11 : 10; }}); }, 200)">"""
"""Draws joints and centres of mass in front of the bodies, which would hide them. Without it they are seen outside of bodies only."""


class Look:
    """The snippet, and the sun's place: made anew when the scene has become larger or smaller."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._style = page.server.gui.add_html("")
        self._sun = page.server.gui.add_html("")
        page.server.gui.add_html(ON_TOP)
        self._middle, self._radius = np.zeros(3), 0.0
        self.apply_theme()

    def apply_theme(self) -> None:
        """Dark or light."""
        self._style.content = STYLE.replace("BACKGROUND", ", ".join(map(str, BACKGROUND[self._page.dark])))

    def refresh(self, frame: Frame) -> None:
        """Fit the shadows to the scene."""
        middle, radius = extent(frame, self._page.stage.scale.width)
        if not self._page.shown.shadows:
            middle, radius = np.zeros(3), 0.0
        resized = radius > self._radius * CHANGE or radius * CHANGE < self._radius
        moved = np.sqrt(((middle - self._middle) ** 2).sum()) > 0.25 * self._radius
        if resized or moved or not self._sun.content:
            self._middle, self._radius = middle, radius
            toward = DIRECTION / np.sqrt((DIRECTION**2).sum())
            values = dict(zip("XYZ", middle, strict=True), RADIUS=1.3 * radius, PIXELS=SHADOW_PIXELS)
            text = SUN
            for name, value in (*zip(("TOX", "TOY", "TOZ"), toward, strict=True), *values.items()):
                text = _with(text, name, value)
            self._sun.content = text


def _with(text: str, name: str, value: Any) -> str:
    import re

    return re.sub(rf"\b{name}\b", f"{value:.6g}", text)


def extent(frame: Frame, width: float) -> tuple[Any, float]:
    """(3,) the middle of the bodies, and the radius about it that holds nearly all of them: what has flown far away is left out [m].

    Args:
        frame: a moment.
        width: of a typical body, by which the radius is widened [m].
    """
    places = frame.position[~frame.table.is_plane & ~np.isnan(frame.position[:, 0])]
    if len(places) == 0:
        return np.zeros(3), 4 * width
    low, high = np.quantile(places, (0.02, 0.98), axis=0)
    return 0.5 * (low + high), float(np.sqrt(((high - low) ** 2).sum())) / 2 + 4 * width
