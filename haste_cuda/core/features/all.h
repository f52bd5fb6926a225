#pragma once

// For programs that decide at run time what of a scene they need: those of the processor.
#include "core/features/ambient.h"
#include "core/features/bounces.h"
#include "core/features/clamp.h"
#include "core/features/dielectric.h"
#include "core/features/diffuse.h"
#include "core/features/environment.h"
#include "core/features/mesh_lights.h"
#include "core/features/mirror.h"
#include "core/features/several_lights.h"
#include "core/features/smooth_normals.h"
#include "core/features/specular.h"
#include "core/features/sphere_lights.h"
#include "core/features/spheres.h"
#include "core/features/transmission.h"
#include "core/features/triangles.h"
#include "core/features/twosided.h"
