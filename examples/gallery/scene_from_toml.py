"""
A scene of one's own, in a file
===============================

A scene file says what is in a world, and nothing else. ``atlasphys run my_scene.toml``, ``atlasphys view
my_scene.toml`` and ``ap.load_scene`` read it.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
from drawing import draw

import atlasphys as ap

text = """
version = 1
name = "seesaw"
seconds = 3

[[bodies]]
shape = { type = "plane" }
friction = 0.8

[[bodies]]
name = "prop"
shape = { type = "cylinder", radius = 0.4, length = 1 }
position = [0, 0.4, 0]
orientation = [0.70710678, 0.70710678, 0, 0]    # lies along z
kind = "static"

[[bodies]]
name = "plank"
shape = { type = "box", size = [5, 0.1, 1] }
position = [0, 0.86, 0]
mass = 20
friction = 0.8

[[bodies]]
name = "light"
shape = { type = "box", size = [0.5, 0.5, 0.5] }
position = [2, 1.17, 0]
mass = 15
friction = 0.8

[[bodies]]
name = "heavy"
shape = { type = "sphere", radius = 0.4 }
position = [-2, 3.5, 0]
mass = 60
"""
path = Path(tempfile.mkdtemp()) / "seesaw.toml"
path.write_text(text)
scene = ap.load_scene(path)
print(scene)

# %%
# ``scene.build()`` makes the world, with other settings than the scene's where one wants them.

world = scene.build(substeps=8)
figure, panels = plt.subplots(1, 3, figsize=(10, 3.8), sharex=True, sharey=True, layout="constrained")
for axes, until in zip(panels, (0.0, 0.75, 1.1), strict=True):
    world.run(seconds=until - world.time, dt=1 / 120) if until else None
    draw(axes, world, labels=True)
    axes.set(title=f"{until} s", xlim=(-3.5, 3.5), ylim=(-0.3, 4.2), xlabel="x [m]")
panels[0].set_ylabel("y [m]")
plt.show()
assert world.bodies["light"].position[1] > 1.5  # it was thrown up

# %%
# Mistakes are all told at once, each with its line, what is wrong, and what would be right:

wrong = text.replace("mass = 20", "mas = 20").replace("radius = 0.4 }", "radius = -0.4 }")
bad = path.with_name("wrong.toml")
bad.write_text(wrong)
try:
    ap.load_scene(bad)
except ap.SceneError as error:
    print(str(error).replace(str(bad.parent) + "/", ""))
else:
    raise AssertionError("a wrong scene was taken")

# %%
# A world becomes a scene again, and a file: ``ap.Scene.from_world(world).save("later.toml")``. :doc:`/scenes`
# has the whole schema.
