"""Prints, as JSON, the inputs of the hair node of a program: `bpy` (Blender) or `MaterialX`."""
import json
import sys

if sys.argv[1] == "bpy":
    import bpy

    material = bpy.data.materials.new("hair")
    material.use_nodes = True
    node = material.node_tree.nodes.new("ShaderNodeBsdfHairPrincipled")
    node.model = "CHIANG"
    node.parametrization = "ABSORPTION"
    names = [socket.name for socket in node.inputs if socket.enabled]
else:
    import MaterialX

    library = MaterialX.createDocument()
    MaterialX.loadLibraries(MaterialX.getDefaultDataLibraryFolders(), MaterialX.getDefaultDataSearchPath(), library)
    names = [i.getName() for i in library.getNodeDef("ND_chiang_hair_bsdf").getInputs()]
print(json.dumps(names))
