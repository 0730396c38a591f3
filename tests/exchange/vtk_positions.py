#!/usr/bin/python3
"""VTK reads a .pvd: where the vertices of a body are at the moments of a run's surfaces.

    vtk_positions.py FILE.pvd BODY RUN TOLERANCE

VTK has no reader of .pvd itself (ParaView has): the list is read here, the .vtu files by VTK.
"""
import math
import os
import sys
import xml.etree.ElementTree

from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from read_exports import read_run  # noqa: E402

path, body, run, tolerance = sys.argv[1:]
sets = [(float(d.get('timestep')), os.path.join(os.path.dirname(path), d.get('file')))
        for d in xml.etree.ElementTree.parse(path).getroot().iter('DataSet')
        if d.get('group') == body]
worst, seen = 0.0, 0
for time, wanted in read_run(run):
    near = [name for t, name in sets if abs(t - time) < 1e-6]
    assert len(near) == 1, (time, near)
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(near[0])
    reader.Update()
    grid = reader.GetOutput()
    assert grid.GetNumberOfPoints() == len(wanted) and grid.GetCellType(0) == 5
    moved = grid.GetPointData().GetArray('displacement')
    assert moved.GetNumberOfTuples() == len(wanted) and moved.GetNumberOfComponents() == 3
    size = max(max(x[k] for x in wanted) - min(x[k] for x in wanted) for k in range(3))
    size = max(size, max(abs(c) for x in wanted for c in x))  # floats know seven digits of a place
    worst = max(worst, max(math.dist(grid.GetPoint(v), x) for v, x in enumerate(wanted)) / size)
    seen += 1
print(f"{os.path.basename(path)}: VTK has '{body}' at {seen} moments to {worst:.1e} of its size")
sys.exit(0 if seen > 1 and worst <= float(tolerance) else 1)
