"""Geometries that particles wear: chains of plates, arcs, screws, and meshes from files.

A description (`kinds`) becomes triangles (`shapes`, `chute`, `screw`, `mesh_files`), and these
become the `abradem.dem.surface.Surface` of the engine, whose triangles are the wear cells
(`build`). `feed` places the factory above it. Lengths are in metres, y points up.
"""
