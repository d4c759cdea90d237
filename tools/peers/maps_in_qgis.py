"""Opens maps with QGIS, prints their classes, and draws each as a picture beside it. Ends with 1 if QGIS does not open a map, has no style for it, or
finds a value without a class."""

import sys

from qgis.core import NULL, QgsApplication, QgsMapRendererSequentialJob, QgsMapSettings, QgsRenderContext, QgsVectorLayer
from qgis.PyQt.QtCore import QSize


def classes(renderer):
    """Returns the classes of a renderer as (values, label, colour)."""
    if hasattr(renderer, "ranges"):
        return [(f"{one.lowerValue():g}..{one.upperValue():g}", one.label(), one.symbol().color().name()) for one in renderer.ranges()]
    if hasattr(renderer, "categories"):
        return [(str(one.value()), one.label(), one.symbol().color().name()) for one in renderer.categories()]
    return []


def drawn(layer, path):
    """Draws a layer as QGIS does."""
    settings = QgsMapSettings()
    settings.setLayers([layer])
    settings.setOutputSize(QSize(900, 700))
    settings.setDestinationCrs(layer.crs())
    settings.setExtent(layer.extent())
    job = QgsMapRendererSequentialJob(settings)
    job.start()
    job.waitForFinished()
    return job.renderedImage().save(path)


def main() -> int:
    application = QgsApplication([], False)
    application.initQgis()
    faults = 0
    for path in sys.argv[1:]:
        layer = QgsVectorLayer(path, path, "ogr")
        if not layer.isValid():
            print(f"{path}: QGIS does not open it")
            faults += 1
            continue
        renderer, found = layer.renderer(), classes(layer.renderer())
        context = QgsRenderContext()
        renderer.startRender(context, layer.fields())
        features = [feature for feature in layer.getFeatures() if found and feature[renderer.classAttribute()] != NULL]
        without = sum(renderer.symbolForFeature(feature, context) is None for feature in features)
        renderer.stopRender(context)
        of = renderer.classAttribute() if found else "no style"
        print(f"{path}: {layer.featureCount()} polygons in {layer.crs().authid()}, {of}: {len(found)} classes, {len(features)} values, {without} without a class")
        for values, label, colour in found:
            print(f"  {values:>20}  {colour}  {label}")
        faults += without + (not features) + (not drawn(layer, f"{path}.png"))
    return min(faults, 1)


sys.exit(main())
