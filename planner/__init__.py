"""The reflective agent's reasoning: knowledge base, planning problem, engines, plan-nets. Pure; imports nothing of ours."""
