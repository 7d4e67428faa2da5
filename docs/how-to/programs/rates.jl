# Rates of a free rod of ten links under thrust, and a run by DifferentialEquations.jl.
using OrdinaryDiffEq

const ROD = joinpath(@__DIR__, "librod.so")

function rates!(dy, y, p, t)
    ccall((:rod_free_n10_follower_gravity_c_rhs, ROD), Cvoid,
          (Cdouble, Ptr{Cdouble}, Ptr{Cdouble}, Ptr{Cdouble}), t, y, p, dy)
    return nothing
end

p = [50.0, 5.0, 100.0, 30.0, 0.0, 0.0]  # mass, length, bending_stiffness, follower_force, ...
y0 = zeros(24)
y0[3] = 0.05                            # phi_0; Julia counts from 1
motion = solve(ODEProblem(rates!, y0, (0.0, 10.0), p), Vern9(); reltol=1e-8)
println(motion.u[end][3])
