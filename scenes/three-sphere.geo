// The mesh of three-sphere-mesh.toml:
//
//   gmsh -3 three-sphere.geo
//
// writes three-sphere.msh: three unit spheres on the x axis, arms of 10, in a ball of radius 40 or
// (-setnumber box 1) in a box of 80 x 60 x 60. Element sizes grow linearly with the distance from
// the spheres. -setnumber size 0.3 changes a number below. -algo hxt uses Gmsh's parallel Delaunay
// algorithm. -optimize_netgen removes flat cells at the spheres, which curved faces may fold: a
// third to a half of the coarser meshes need it.
SetFactory("OpenCASCADE");
DefineConstant[
  box = 0,        // 1: a box instead of a ball
  arm = 10,       // distance of the outer spheres from the middle one
  size = 0.4,     // element size on the spheres
  growth = 0.25,  // growth of the size with the distance from them
  largest = 6     // largest size
];
If (box)
  Box(1) = {-40, -30, -30, 80, 60, 60};
Else
  Sphere(1) = {0, 0, 0, 40};
EndIf
Sphere(2) = {-arm, 0, 0, 1};
Sphere(3) = {0, 0, 0, 1};
Sphere(4) = {arm, 0, 0, 1};
BooleanDifference(5) = { Volume{1}; Delete; }{ Volume{2:4}; Delete; };

left() = Surface In BoundingBox {-arm - 1.1, -1.1, -1.1, -arm + 1.1, 1.1, 1.1};
centre() = Surface In BoundingBox {-1.1, -1.1, -1.1, 1.1, 1.1, 1.1};
right() = Surface In BoundingBox {arm - 1.1, -1.1, -1.1, arm + 1.1, 1.1, 1.1};
wall() = Surface{:};
wall() -= {left(), centre(), right()};
Physical Surface("sphere1") = left();
Physical Surface("sphere2") = right();
Physical Surface("sphere3") = centre();
Physical Surface("outer") = wall();
Physical Volume("fluid") = {5};

Field[1] = Distance;
Field[1].SurfacesList = {left(), centre(), right()};
Field[1].Sampling = 40;
Field[2] = MathEval;
Field[2].F = Sprintf("Min(%g, %g + %g * F1)", largest, size, growth);
Background Field = 2;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.Binary = 1;
