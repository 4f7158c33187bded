// Quantities as types, so that a signature says what it takes. SI units; angles in radians.

#define Number float
#define Length float              // m
#define Angle float               // rad
#define Column float              // air column in scale heights
#define NumberDensity float       // m^-3
#define CrossSection float        // m^2 sr^-1, per drop
#define ColumnDensity float       // m^-2: drops along a ray
#define Direction vec3            // unit vector: x east, y north, z up
#define Position vec3             // m, relative to the eye: float32 keeps its digits near the eye
#define Tristimulus vec3          // X, Y, Z with Y in cd/m^2

const float PI = 3.14159265358979;
