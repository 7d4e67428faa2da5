"""The mechanics of a planar chain of rigid links, in SymPy and nothing else.

    symbols      the letters of the model, and the quantities along the chain
    chain        kinematics, written once
    link_properties   mass of the links and stiffness of the joints
    explicit_chain, generic_chain   n links, and any number of them, before their loads
    loads/       a file a load: its law, its closed form; kinds: what follows from it
    explicit     derivation 1: LagrangesMethod with n links
    general      derivation 2: for every n at once; what is emitted comes from here
    joint_force_system   derivation 3: joints as constraints, in O(n); tensions: massless links
    energies     energies, power and geometry, for every n
    closed_form  the hand-assembled matrices, only ever compared with
    proofs/      the comparisons, entry by entry and at rational points

Source of the model: J. Masek, Modelling of free beam loaded by follower load, Brno 2014,
chapter 2; every formula is derived here, none is transcribed.
"""

import os

# SymPy keeps a thousand results, and a rod with every load asks for more: that would take up to
# three times as long. It reads this when it is first imported.
REMEMBERED = os.environ.setdefault("SYMPY_CACHE_SIZE", "100000")
