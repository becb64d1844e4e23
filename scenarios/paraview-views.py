"""Views of a run's fields: a ParaView state to continue with, or pictures by VTK's wheel alone.

    pvpython scenarios/paraview-views.py RUN [FOLDER]    # xvfb-run pvpython ... without a screen
    python scenarios/paraview-views.py RUN [FOLDER]            # after pip install vtk
    File > Run Script in ParaView's menu Tools > Python Shell, with the run in the environment variable THIRDBODY_RUN

RUN is a run directory, by default runs/latest. The pictures go to FOLDER, by default RUN/views, and ParaView's state to views.pvsm
there. The script leaves out views without data in the run and prints their names. All views show the last time:

contact       sizes of displacements in the mesh and the status of its contact nodes (Renouf, Saulot and Berthier 2006, figures 4 and 5)
pressure      hydrostatic pressure in the mesh and mean pressure in the grains on one scale (figure 4)
motion        displacements of the grains since the start, and their velocities as arrows (figures 9 and 10)
force-chains  contacts of the grains, as wide as their normal force
"""

import json
import math
import os
import sys
from pathlib import Path
from xml.etree import ElementTree

try:
    from paraview import simple
except ImportError:
    simple = None

SIZE = (1600, 800)
# Left, lower, right and upper end of the drawing in a picture; there is text above and below.
VIEWPORT = (0.0, 0.15, 1.0, 0.91)
GREY = (0.82, 0.82, 0.82)
DARK = (0.1, 0.1, 0.1)
# Dark blue to yellow.
COLOURS = [(0.27, 0.00, 0.33), (0.23, 0.32, 0.55), (0.13, 0.57, 0.55), (0.37, 0.79, 0.38), (0.99, 0.91, 0.14)]
# Open, stick and slip.
STATUSES = [(0.6, 0.6, 0.6), (0.1, 0.6, 0.2), (0.85, 0.1, 0.1)]
VECTORS = ("displacement_m", "displacement_since_start_m", "velocity_m_per_s", "traction_pa")


def parts(run):
    """The file of each part at the last time of fields.pvd, and that time (s)."""
    path = run / "fields.pvd"
    if not path.exists() and any(run.glob("fields/*.vtkhdf")):
        sys.exit(f"{run} has its fields as VTKHDF: open fields/*.vtkhdf in ParaView; this script reads run.output.fields_format = \"vtk-xml\"")
    if not path.exists():
        sys.exit(f"{path} is missing: the run wrote no fields (run.output.fields = false?), or this is not a run directory")
    sets = list(ElementTree.parse(path).getroot().iter("DataSet"))
    last = max(float(s.get("timestep")) for s in sets)
    return {s.get("name"): run / s.get("file") for s in sets if float(s.get("timestep")) == last}, last


class Drawn:
    """A run at its last time, read by VTK: the parts by kind, and the data that the views share."""

    def __init__(self, run):
        from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

        self.run = run
        files, self.time_s = parts(run)
        self.data = {}
        for name, path in files.items():
            reader = {".vtu": vtkXMLUnstructuredGridReader, ".vtp": vtkXMLPolyDataReader}[path.suffix]()
            reader.SetFileName(str(path))
            reader.Update()
            self.data[name] = reader.GetOutput()
        self.meshes = self.of_kind("hydrostatic_pressure_pa")
        self.grains = self.of_kind("radius_m")
        self.contacts = self.of_kind("force_n")

    def of_kind(self, array):
        """Names of the parts that have this array."""
        return [name for name, data in self.data.items() if array_of(data, array)]

    def box(self, names):
        """Left, right, lower and upper end of some parts (m)."""
        bounds = [self.data[name].GetBounds() for name in names]
        return [pick(b[k] for b in bounds) for k, pick in ((0, min), (1, max), (2, min), (3, max))]

    def busiest(self):
        """The largest normal force of a contact (N), and its position (m)."""
        best = (0.0, None)
        for name in self.contacts:
            data = self.data[name]
            force = array_of(data, "force_n")
            for cell in range(data.GetNumberOfCells()):
                if force.GetComponent(cell, 0) > best[0]:
                    best = (force.GetComponent(cell, 0), data.GetPoint(data.GetCell(cell).GetPointId(0)))
        return best


def array_of(data, name):
    """An array of points or of cells."""
    return data.GetPointData().GetArray(name) or data.GetCellData().GetArray(name)


def largest(drawn, names, array):
    """The largest value of an array, or length of a vector, in some parts."""
    ends = [array_of(drawn.data[name], array) for name in names]
    return max((a.GetRange(-1 if a.GetNumberOfComponents() > 1 else 0)[1] for a in ends if a and a.GetNumberOfTuples()), default=0.0)


def round_factor(largest_m, width_m):
    """A factor of 1, 2 or 5 times a power of ten, at least 1, that makes the largest displacement a thirtieth of the width."""
    wanted = width_m / 30 / largest_m if largest_m > 0 else 1.0
    power = 10.0 ** math.floor(math.log10(max(wanted, 1.0)))
    return max(f * power for f in (1, 2, 5) if f * power <= max(wanted, 1.0))


def layers(drawn):
    """The views of this run: a name, a title, the window (centre x, centre y, width in m) and layers.

    A layer is (way of drawing, part, array, label, range, factor or width)."""
    views, left_out = [], []
    mesh, grains, contacts = drawn.meshes, drawn.grains, drawn.contacts
    moved = largest(drawn, mesh, "displacement_m")
    radius = largest(drawn, grains, "radius_m") or 1e-4
    if mesh:
        left, right, low, high = drawn.box(mesh)
        factor = round_factor(moved, right - left)
        label = "displacement (m)"
        list_ = [("cells", n, "displacement_m", label, (0.0, moved), factor) for n in mesh]
        status = [n for n in mesh if array_of(drawn.data[n], "node_status")]
        list_ += [("status", n, "node_status", "contact nodes", (0, 2), factor) for n in status]
        nodes = "; contact nodes: green stick, red slip, grey open" if status else ""
        window = (0.5 * (left + right), 0.5 * (low + high), 1.1 * (right - left))
        views.append(("contact", f"displacements, drawn {factor:g} times as large{nodes}", window, list_))
    else:
        left_out.append("contact: no mesh")
    if mesh or grains:
        views.append(pressure(drawn))
    else:
        left_out.append("pressure: neither mesh nor grains")
    if grains:
        left, right, low, high = drawn.box(grains)
        width = min(1.08 * (right - left), 90 * radius)
        window = (0.5 * (left + right), 0.5 * (low + high), width)
        most = largest(drawn, grains, "displacement_since_start_m") or 1.0
        list_ = [("disks", n, "displacement_since_start_m", "displacement (m)", (0.0, most), 1.0) for n in grains]
        speed = largest(drawn, grains, "velocity_m_per_s")
        if speed > 0:
            list_ += [("arrows", n, "velocity_m_per_s", None, None, 4 * radius / speed) for n in grains]
        views.append(("motion", f"displacements since the start; arrows: velocities, the longest {speed:.3g} m/s", window, list_))
    else:
        left_out.append("motion: no grains")
    force_n, place = drawn.busiest()
    if place:
        list_ = [("pale", n, None, None, None, 1.0) for n in grains]
        list_ += [("chains", n, "force_n", "normal force (N)", (0.0, force_n), radius) for n in contacts]
        left, right, _, _ = drawn.box(grains or contacts)
        width = min(1.05 * (right - left), 60 * radius)
        views.append(("force-chains", f"contacts, as wide as their normal force: up to {force_n:.3g} N", (place[0], place[1], width), list_))
    else:
        left_out.append("force-chains: no contact presses")
    for reason in left_out:
        print(f"left out: {reason}")
    return views


def pressure(drawn):
    """Pressure in meshes and grains, on one scale."""
    mesh, grains = drawn.meshes, drawn.grains
    left, right, low, high = drawn.box(grains or mesh)
    width = 1.08 * (right - left)
    window = (0.5 * (left + right), 0.5 * (low + high) - (0.16 * width if mesh and grains else 0.0), width)
    top = max(largest(drawn, mesh, "hydrostatic_pressure_pa"), of_most_grains(drawn))
    words = [text for text, there in [("in the mesh tr(sigma)/3", mesh), ("in the plane of the grains, 1 of 50 beyond the scale", grains)] if there]
    layers = [("cells", n, "hydrostatic_pressure_pa", "pressure (Pa)", (0.0, top or 1.0), 1.0) for n in mesh]
    layers += [("disks", n, "pressure_pa", "pressure (Pa)", (0.0, top or 1.0), 1.0) for n in grains]
    return "pressure", f"pressure {', '.join(words)}; displacements not enlarged", window, layers


def of_most_grains(drawn):
    """The pressure that one grain of fifty exceeds (Pa): single grains would stretch the scale."""
    arrays = [array_of(drawn.data[name], "pressure_pa") for name in drawn.grains]
    values = sorted(a.GetValue(k) for a in arrays for k in range(a.GetNumberOfTuples()))
    return values[int(0.98 * (len(values) - 1))] if values else 0.0


def caption(drawn, title):
    """The two lines of text above a picture."""
    name = drawn.run.resolve().name
    summary = drawn.run / "summary.json"
    if summary.exists():
        name = json.loads(summary.read_text())["scenario"]
    return f"{name}, t = {1e3 * drawn.time_s:.4g} ms\n{title}"


class VtkPictures:
    """Pictures by VTK alone, off-screen."""

    def __init__(self, drawn, folder):
        if "DISPLAY" not in os.environ:
            os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
        import vtkmodules.vtkInteractionStyle  # noqa: F401
        import vtkmodules.vtkRenderingFreeType  # noqa: F401
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401

        self.drawn, self.folder = drawn, folder

    def picture(self, name, title, window, layers):
        from vtkmodules.vtkIOImage import vtkPNGWriter
        from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter

        scene, frame = vtkRenderer(), vtkRenderer()
        scene.SetViewport(*VIEWPORT)
        frame.InteractiveOff()
        for part in (frame, scene):
            part.SetBackground(1, 1, 1)
        bars = {}
        for way, part, array, label, span, factor in layers:
            actor = self.actor(way, self.drawn.data[part], array, span, factor)
            scene.AddActor(actor)
            if label and way != "status":
                bars[label] = actor.GetMapper().GetLookupTable()
        for label, table in bars.items():
            frame.AddViewProp(self.bar(table))
            frame.AddViewProp(self.text(label, (0.79, 0.03), "bottom"))
        frame.AddViewProp(self.text(caption(self.drawn, title), (0.02, 0.985), "top"))
        self.rule(frame, window[2])
        self.look(scene, window)
        screen = vtkRenderWindow()
        screen.SetOffScreenRendering(1)
        screen.SetSize(*SIZE)
        screen.SetMultiSamples(4)
        for part in (frame, scene):
            screen.AddRenderer(part)
        screen.Render()
        image = vtkWindowToImageFilter()
        image.SetInput(screen)
        image.ReadFrontBufferOff()
        writer = vtkPNGWriter()
        path = self.folder / f"{name}.png"
        writer.SetFileName(str(path))
        writer.SetInputConnection(image.GetOutputPort())
        writer.Write()
        print(path)

    def actor(self, way, data, array, span, factor):
        from vtkmodules.vtkRenderingCore import vtkActor, vtkDataSetMapper

        shape = {
            "cells": self.moved, "status": self.touching, "disks": self.disks,
            "pale": self.disks, "arrows": self.arrows, "chains": self.chains,
        }[way](data, factor, span)
        mapper = vtkDataSetMapper()
        mapper.SetInputData(shape)
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().LightingOff()
        colour = {"pale": GREY, "arrows": DARK}.get(way)
        if colour:
            mapper.ScalarVisibilityOff()
            actor.GetProperty().SetColor(*colour)
            return actor
        source = "normal_force_n" if way == "chains" else array
        if shape.GetPointData().GetArray(source):
            mapper.SetScalarModeToUsePointFieldData()
        else:
            mapper.SetScalarModeToUseCellFieldData()
        mapper.SelectColorArray(source)
        mapper.SetLookupTable(self.statuses() if way == "status" else self.colours(source, span))
        mapper.UseLookupTableScalarRangeOff()
        mapper.SetScalarRange(*span)
        if way == "status":
            actor.GetProperty().SetPointSize(7)
            actor.GetProperty().RenderPointsAsSpheresOn()
        return actor

    def moved(self, data, factor, _):
        """A mesh moved by `factor` times its displacement."""
        from vtkmodules.vtkFiltersGeneral import vtkWarpVector

        warp = vtkWarpVector()
        warp.SetInputData(data)
        warp.SetInputArrayToProcess(0, 0, 0, 0, "displacement_m")
        warp.SetScaleFactor(factor)
        warp.Update()
        return warp.GetOutput()

    def touching(self, data, factor, _):
        """The nodes of the contact surface."""
        from vtkmodules.vtkFiltersCore import vtkThresholdPoints

        threshold = vtkThresholdPoints()
        threshold.SetInputData(self.moved(data, factor, None))
        threshold.SetInputArrayToProcess(0, 0, 0, 0, "node_status")
        threshold.SetUpperThreshold(-0.5)
        threshold.SetThresholdFunction(vtkThresholdPoints.THRESHOLD_UPPER)
        threshold.Update()
        return threshold.GetOutput()

    def disks(self, data, _, __):
        """Grains as disks of their radius."""
        from vtkmodules.vtkFiltersSources import vtkRegularPolygonSource

        polygon = vtkRegularPolygonSource()
        polygon.SetNumberOfSides(24)
        polygon.SetRadius(1.0)
        return self.glyphs(data, polygon, "radius_m", 1.0)

    def arrows(self, data, factor, _):
        """Velocities as arrows, `factor` metres long per m/s."""
        from vtkmodules.vtkFiltersSources import vtkArrowSource

        arrow = vtkArrowSource()
        arrow.SetShaftRadius(0.02)
        arrow.SetTipRadius(0.07)
        arrow.SetTipLength(0.25)
        return self.glyphs(data, arrow, "velocity_m_per_s", factor)

    def glyphs(self, data, source, array, factor):
        from vtkmodules.vtkFiltersCore import vtkGlyph3D

        glyph = vtkGlyph3D()
        glyph.SetInputData(data)
        glyph.SetSourceConnection(source.GetOutputPort())
        if data.GetPointData().GetArray(array).GetNumberOfComponents() > 1:
            glyph.SetInputArrayToProcess(1, 0, 0, 0, array)
            glyph.SetScaleModeToScaleByVector()
            glyph.SetVectorModeToUseVector()
        else:
            glyph.SetInputArrayToProcess(0, 0, 0, 0, array)
            glyph.SetScaleModeToScaleByScalar()
            glyph.OrientOff()
        glyph.SetScaleFactor(factor)
        glyph.Update()
        return glyph.GetOutput()

    def chains(self, data, radius, span):
        """Contacts as strips as wide as their normal force, the widest a grain's radius."""
        from vtkmodules.vtkCommonCore import vtkDoubleArray, vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

        force = array_of(data, "force_n")
        points, strips, values = vtkPoints(), vtkCellArray(), vtkDoubleArray()
        points.SetDataTypeToDouble()
        values.SetName("normal_force_n")
        for cell in range(data.GetNumberOfCells()):
            size = force.GetComponent(cell, 0)
            if size <= 0.0:
                continue
            ends = data.GetCell(cell).GetPointIds()
            a, b = (data.GetPoint(ends.GetId(k)) for k in (0, 1))
            along = (b[0] - a[0], b[1] - a[1])
            half = 0.5 * radius * size / span[1] / (math.hypot(*along) or 1.0)
            aside = (-half * along[1], half * along[0])
            corners = [(p[0] + s * aside[0], p[1] + s * aside[1], 1e-6) for p, s in ((a, 1), (b, 1), (b, -1), (a, -1))]
            strips.InsertNextCell(4, [points.InsertNextPoint(corner) for corner in corners])
            values.InsertNextValue(size)
        shape = vtkPolyData()
        shape.SetPoints(points)
        shape.SetPolys(strips)
        shape.GetCellData().AddArray(values)
        return shape

    def colours(self, array, span):
        """Dark blue to yellow; vectors are coloured by their length."""
        from vtkmodules.vtkRenderingCore import vtkColorTransferFunction

        table = vtkColorTransferFunction()
        low, high = span
        for k, colour in enumerate(COLOURS):
            table.AddRGBPoint(low + k / (len(COLOURS) - 1) * (high - low), *colour)
        if array in VECTORS:
            table.SetVectorModeToMagnitude()
        return table

    def statuses(self):
        from vtkmodules.vtkCommonCore import vtkLookupTable

        table = vtkLookupTable()
        table.SetNumberOfTableValues(3)
        for k, colour in enumerate(STATUSES):
            table.SetTableValue(k, *colour, 1.0)
        return table

    def text(self, words, place, vertical):
        from vtkmodules.vtkRenderingCore import vtkTextActor

        text = vtkTextActor()
        text.SetInput(words)
        style = text.GetTextProperty()
        style.SetFontSize(24)
        style.SetColor(*DARK)
        if vertical == "top":
            style.SetVerticalJustificationToTop()
        text.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
        text.GetPositionCoordinate().SetValue(*place)
        return text

    def bar(self, table):
        from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor

        bar = vtkScalarBarActor()
        bar.SetLookupTable(table)
        bar.SetNumberOfLabels(5)
        bar.SetLabelFormat("{:.2e}")
        bar.SetOrientationToHorizontal()
        bar.SetPosition(0.3, 0.015)
        bar.SetWidth(0.45)
        bar.SetHeight(0.1)
        style = bar.GetLabelTextProperty()
        style.SetColor(*DARK)
        style.ItalicOff()
        style.ShadowOff()
        style.BoldOff()
        style.SetFontSize(20)
        bar.UnconstrainedFontSizeOn()
        return bar

    def rule(self, frame, width):
        """A scale bar of a round length, with its length in text."""
        from vtkmodules.vtkFiltersSources import vtkLineSource
        from vtkmodules.vtkRenderingCore import vtkActor2D, vtkCoordinate, vtkPolyDataMapper2D

        length = 10.0 ** math.floor(math.log10(0.15 * width))
        length = max(f * length for f in (1, 2, 5) if f * length <= 0.15 * width)
        line, place, mapper, actor = vtkLineSource(), vtkCoordinate(), vtkPolyDataMapper2D(), vtkActor2D()
        line.SetPoint1(0.02, 0.05, 0)
        line.SetPoint2(0.02 + length / width, 0.05, 0)
        place.SetCoordinateSystemToNormalizedViewport()
        mapper.SetInputConnection(line.GetOutputPort())
        mapper.SetTransformCoordinate(place)
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(*DARK)
        actor.GetProperty().SetLineWidth(4)
        frame.AddViewProp(actor)
        frame.AddViewProp(self.text(f"{1e3 * length:g} mm", (0.02, 0.065), "bottom"))

    def look(self, scene, window):
        x, y, width = window
        camera = scene.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(x, y, 0)
        camera.SetPosition(x, y, 1)
        camera.SetParallelScale(0.5 * width * SIZE[1] / SIZE[0] * (VIEWPORT[3] - VIEWPORT[1]))
        scene.ResetCameraClippingRange()


class ParaViewState:
    """The same views in ParaView, in one layout each, over the whole time of the run."""

    def __init__(self, drawn, folder):
        self.drawn, self.folder = drawn, folder
        self.reader = simple.PVDReader(registrationName="fields", FileName=str(drawn.run / "fields.pvd"))
        self.reader.UpdatePipeline(drawn.time_s)
        self.parts = {}

    def part(self, name):
        """One part of fields.pvd, by its name."""
        if name not in self.parts:
            found = self.reader
            # A run with a single part has no blocks.
            tree = self.reader.GetDataInformation().GetHierarchy()
            if tree:
                nodes = tree.GetChildNodes(0, False)
                path = next(tree.GetNodePath(n) for n in nodes if tree.GetAttributeOrDefault(n, "label", tree.GetNodeName(n)) == name)
                found = simple.ExtractBlock(registrationName=name, Input=self.reader, Selectors=[path])
                found = simple.MergeBlocks(registrationName=f"{name} alone", Input=found)
            self.parts[name] = found
        return self.parts[name]

    def picture(self, name, title, window, layers):
        view = simple.CreateView("RenderView")
        simple.AssignViewToLayout(view=view, layout=simple.CreateLayout(name))
        view.ViewSize = list(SIZE)
        view.UseColorPaletteForBackground = 0
        view.Background = [1, 1, 1]
        view.OrientationAxesVisibility = 0
        view.ViewTime = self.drawn.time_s
        bars = set()
        for layer in layers:
            self.show(view, bars, *layer)
        text = simple.Text(registrationName=f"{name} caption", Text=caption(self.drawn, title))
        shown = simple.Show(text, view)
        shown.Color, shown.FontSize, shown.Justification = list(DARK), 18, "Left"
        shown.WindowLocation = "Upper Left Corner"
        x, y, width = window
        view.CameraParallelProjection = 1
        view.CameraFocalPoint, view.CameraPosition = [x, y, 0], [x, y, 1]
        view.CameraViewUp = [0, 1, 0]
        view.CameraParallelScale = 0.5 * width * SIZE[1] / SIZE[0]
        path = self.folder / f"{name}.png"
        simple.SaveScreenshot(str(path), view, ImageResolution=list(SIZE))
        print(path)

    def show(self, view, bars, way, part, array, label, span, factor):
        source = self.part(part)
        shape = {
            "cells": self.moved, "status": self.touching, "disks": self.disks,
            "pale": self.disks, "arrows": self.arrows, "chains": self.chains,
        }[way](source, factor, span)
        shown = simple.Show(shape, view)
        shown.Ambient, shown.Diffuse = 1, 0
        colour = {"pale": GREY, "arrows": DARK}.get(way)
        if colour:
            shown.ColorArrayName = [None, ""]
            shown.AmbientColor = shown.DiffuseColor = list(colour)
            return
        cells = array in ("hydrostatic_pressure_pa", "force_n") and way != "chains"
        name = "normal_force_n" if way == "chains" else array
        # A separate table per view: the same array has other ranges in other views.
        simple.ColorBy(shown, ("CELLS" if cells else "POINTS", name), separate=True)
        table = simple.GetColorTransferFunction(name, shown, separate=True)
        table.ColorSpace = "RGB"
        stops = STATUSES if way == "status" else COLOURS
        low, high = span
        marks = [low + k / (len(stops) - 1) * (high - low) for k in range(len(stops))]
        table.RGBPoints = [x for mark, colour in zip(marks, stops) for x in (mark, *colour)]
        if way == "status":
            shown.SetRepresentationType("Points")
            shown.PointSize = 7
            return
        if label in bars:
            return
        bars.add(label)
        bar = simple.GetScalarBar(table, view)
        bar.Title, bar.ComponentTitle = label, "size" if array in VECTORS else ""
        bar.TitleColor = bar.LabelColor = list(DARK)
        bar.Orientation, bar.WindowLocation, bar.ScalarBarLength = "Horizontal", "Lower Center", 0.4
        bar.UseCustomLabels, bar.AddRangeLabels = 1, 0
        bar.CustomLabels = [low + k / 4 * (high - low) for k in range(5)]
        bar.AutomaticLabelFormat, bar.LabelFormat = 0, "%-#.2e"
        bar.DrawBackground, bar.BackgroundColor = 1, [1, 1, 1, 0.9]
        bar.Visibility = 1

    def moved(self, source, factor, _):
        return simple.WarpByVector(Input=source, Vectors=["POINTS", "displacement_m"], ScaleFactor=factor)

    def touching(self, source, factor, _):
        moved = self.moved(source, factor, None)
        found = simple.Threshold(Input=moved, Scalars=["POINTS", "node_status"], LowerThreshold=-0.5, UpperThreshold=2.5)
        found.AllScalars = 0
        return simple.MaskPoints(Input=found, OnRatio=1, GenerateVertices=1, SingleVertexPerCell=1, MaximumNumberofPoints=10**7)

    def disks(self, source, _, __):
        glyph = simple.Glyph(Input=source, GlyphType="2D Glyph")
        glyph.GlyphType.GlyphType, glyph.GlyphType.Filled = "Circle", 1
        glyph.OrientationArray, glyph.ScaleArray = ["POINTS", "No orientation array"], ["POINTS", "radius_m"]
        # ParaView's circle has a radius of one half.
        glyph.ScaleFactor, glyph.GlyphMode = 2.0, "All Points"
        return glyph

    def arrows(self, source, factor, _):
        glyph = simple.Glyph(Input=source, GlyphType="Arrow")
        glyph.OrientationArray = glyph.ScaleArray = ["POINTS", "velocity_m_per_s"]
        glyph.VectorScaleMode = "Scale by Magnitude"
        glyph.ScaleFactor, glyph.GlyphMode = factor, "All Points"
        arrow = glyph.GlyphType
        arrow.ShaftRadius, arrow.TipRadius, arrow.TipLength = 0.02, 0.07, 0.25
        return glyph

    def chains(self, source, radius, span):
        force = simple.Calculator(Input=source, AttributeType="Cell Data", ResultArrayName="normal_force_n", Function="max(force_n_0,0)")
        # Lines without common points: each keeps its own force.
        apart = simple.ExtractSurface(Input=simple.Shrink(Input=force, ShrinkFactor=1.0))
        points = simple.CellDatatoPointData(Input=apart)
        width = f"normal_force_n*{0.5 * radius / span[1]:.6e}"
        wide = simple.Calculator(Input=points, AttributeType="Point Data", ResultArrayName="width_m", Function=width)
        tubes = simple.Tube(Input=wide, Scalars=["POINTS", "width_m"], VaryRadius="By Absolute Scalar")
        return tubes


def main(run, folder=None):
    run = Path(run)
    folder = Path(folder) if folder else run / "views"
    folder.mkdir(parents=True, exist_ok=True)
    drawn = Drawn(run)
    pictures = (ParaViewState if simple else VtkPictures)(drawn, folder)
    for view in layers(drawn):
        pictures.picture(*view)
    if simple:
        simple.SaveState(str(folder / "views.pvsm"))
        print(folder / "views.pvsm")


main(*(sys.argv[1:3] or [os.environ.get("THIRDBODY_RUN", "runs/latest")]))
