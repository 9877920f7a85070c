"""The punch on points without a mesh: is the pressure as smooth as on hexahedra?"""
