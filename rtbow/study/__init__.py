"""The paper's figures and claims, and charts of the theories."""
