"""
Events: what began and what ended
=================================

``world.events`` lists what happened in the last step: contacts that began or ended, bodies that fell asleep
or woke. A program that reacts to hits reads these, in place of comparing lists of contacts.
"""

import matplotlib.pyplot as plt

import atlasphys as ap

world = ap.World()
world.add(ap.Plane(normal=(0, 1, 0)), name="ground")
world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5, 0), mass=10, name="crate")
world.add(ap.Sphere(radius=0.3), position=(0, 4, 0), mass=2, restitution=0.7, name="ball")
world.add(ap.Cylinder(radius=0.3, length=1), position=(0.7, 6, 0), mass=4, name="drum")

# %%
# Each event has a ``kind`` and the handles ``a`` and ``b`` of the bodies. The loop remembers since when each
# pair touches.

since, spans, sleeping, asleep_since = {}, [], [], {}
while world.time < 6:
    world.step(1 / 60)
    for event in world.events:
        pair = tuple(body.name for body in (event.a, event.b) if body is not None)
        if event.kind == "contact_begin":
            since[pair] = world.time
        elif event.kind == "contact_end":
            spans.append((pair, since.pop(pair), world.time))
        elif event.kind == "sleep":
            asleep_since[pair[0]] = world.time
        elif event.kind == "wake":
            sleeping.append((pair[0], asleep_since.pop(pair[0]), world.time))
spans += [(pair, begun, world.time) for pair, begun in since.items()]
sleeping += [(name, begun, world.time) for name, begun in asleep_since.items()]

# %%
# A diary of the six seconds:

pairs = sorted({pair for pair, _, _ in spans}, key=lambda pair: min(b for p, b, _ in spans if p == pair))
names = [" – ".join(pair) for pair in pairs] + sorted({f"{name} sleeps" for name, _, _ in sleeping})
figure, axes = plt.subplots(figsize=(8, 3.6), layout="constrained")
for pair, begun, ended in spans:
    axes.barh(" – ".join(pair), ended - begun, left=begun, color="C0", height=0.6)
for name, begun, ended in sleeping:
    axes.barh(f"{name} sleeps", ended - begun, left=begun, color="C7", height=0.6)
axes.set(xlabel="t [s]", xlim=(0, 6), title="blue: the pair touches; grey: the body sleeps")
axes.invert_yaxis()
plt.show()

bounces = [begun for pair, begun, _ in spans if pair == ("crate", "ball")]
print(f"the ball met the crate {len(bounces)} times, first at {bounces[0]:.2f} s")
assert len(bounces) >= 1
assert world.bodies["crate"].asleep

# %%
# The bodies of an event are handles. A game that breaks what is hit hard would read ``world.contacts`` in the
# same step for the impulse.

strongest = world.contacts.normal_impulse.max() if len(world.contacts) else 0.0
print(f"strongest contact of the last step: {60 * strongest:.1f} N")
