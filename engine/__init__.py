"""Computation without a window: no Qt, no VTK, no printing, no global state.

The map, stage by stage (a stage folder of the same name stands in ``widgets`` and ``studio``):

========  =============================================  ==================================
stage     module                                         source
========  =============================================  ==================================
scan      ``scan.range_image`` a scan's points, colour   Yano & Harada 2009, section 3.1
..        ``scan.repair`` spikes, matte gap filling      Williams 1990, steps 0-4
..        ``scan.template`` the flat face and schemes    Yano & Harada 2009, figure 1
..        ``scan.scheme_vertices`` schemes of one's own  ours
..        ``scan.fit`` warp, subdivide, sample           Yano & Harada 2009, section 3.1
..        ``scan.quality`` figures with limits           ours
..        ``scan.carry`` fiducials from scan to scan     ours, on dense inverse search
..        ``scan.mouth`` the opening between the lips    ours
..        ``scan.virtual`` a scanner that knows truth    ours
..        ``scan.orient`` where a mesh has its face     ours
..        ``scan.mesh_view`` a camera before a mesh      ours
..        ``scan.landmark_pixels`` points to pixels      ours
basis     ``basis.markers`` markers bound to a face      Kim & Ko 2007, section 5.1
..        ``basis.head`` the head's motion, removed      ours
..        ``basis.gaps`` gaps of markers, filled         ours, on Tipping & Bishop 1999
..        ``basis.place`` resting markers onto a face    ours
..        ``basis.spread`` from markers to the mesh      Kim & Ko 2007, section 5.2; ours
..        ``basis.principal`` a performance's axes       Kim & Ko 2007, section 4, eq. 2
..        ``basis.reduce`` small, exact coordinates      ours
..        ``basis.quasi_eigen`` shapes projected         Kim & Ko 2007, eq. 3 and 4
..        ``basis.weights`` free or within bounds        Kim & Ko 2007, eq. 5; ours
..        ``basis.error`` alpha and millimetres          Kim & Ko 2007, eq. 6; ours
..        ``basis.extremes`` maxima, percentiles         ours
..        ``basis.compare`` three bases, three bounds    Kim & Ko 2007, section 5.5; ours
..        ``basis.live`` alpha while a slider moves      ours
..        ``basis.advice`` what to sculpt next           ours
..        ``basis.muscles`` the sculpting checklist      Kim & Ko 2007, section 5.3; ours
..        ``shape_edits`` edits of shapes as values      ours
..        ``shape_names`` ARKit and FACS names           Ekman & Friesen 1978; ours
..        ``mirror_map`` the other side of a vertex      ours
shared    ``landmark_mapping`` points of other tools     ours
..        ``geometry.thin_plate`` thin-plate spline      Bookstein 1989
..        ``geometry.subdivide`` 1-to-4 subdivision      Yano & Harada 2009, section 3.1
..        ``geometry.sampling`` bilinear, by validity    ours
..        ``geometry.harmonic`` fill over a mesh         ours
..        ``geometry.normals`` normals, areas            common knowledge
..        ``geometry.distance`` point to surface         common knowledge
..        ``geometry.rigid`` rigid alignment             Kabsch 1976; Umeyama 1991
========  =============================================  ==================================

Values every stage passes on: ``mesh.TriangleMesh``, ``landmarks.LandmarkScheme`` and ``LandmarkSet``.
``files`` holds one module per format; ``errors`` and ``progress`` the two protocols with the caller.

Units: millimetres, radians, seconds. Frame: +Y up, +Z out of the face, left is the subject's left.
Pixels: origin top left, pixel centres at integers.
"""
