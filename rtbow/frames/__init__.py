"""What a picture is: radiance on file, as displayed, compared and measured."""
