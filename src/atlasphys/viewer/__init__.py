"""The interactive world: a viewer in the browser, replay of recordings, pictures and films.

``session`` and ``replay`` are models without a window: commands in, frames out. ``simulation`` runs one of them on its own thread. ``page`` and
the modules of ``gui`` show it with viser; ``render`` makes pictures and films with VTK. Both draw what ``shapes``, ``overlays`` and ``colours`` make.
"""
