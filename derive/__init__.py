"""The mechanics of a planar chain of rigid links, in SymPy and nothing else.

    symbols      the letters of the model
    chain        kinematics, written once
    inertia      how the mass of a link is spread along it
    loads        springs, forces and moments, as local laws
    explicit     derivation 1: LagrangesMethod with n links
    general      derivation 2: for every n at once; what is emitted comes from here
    quantities   energies, power and geometry, for every n
    closed_form  the hand-assembled matrices, only ever compared with
    proof_*      the comparisons, entry by entry; points: at rational points

Source of the model: J. Masek, Modelling of free beam loaded by follower load, Brno 2014,
chapter 2; every formula is derived here, none is transcribed.
"""
